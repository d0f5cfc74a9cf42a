#include <fmt/format.h>
#include <fmt/ranges.h>

#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

/// "0.4", "12"; of a share below a tenth with a decimal.
std::string share_text(double share) {
  return share < 0.1 ? fmt::format("{:.1f}", 100.0 * share) : percent(share);
}

void add_state(const std::string& name, const v1::LineExperience::State& state, v1::Table& table) {
  add_row(table, {text_cell(name), number_cell(state.danger()), number_cell(state.danger_low()),
                  number_cell(state.danger_high()),
                  state.has_low_m() ? number_cell(state.low_m()) : v1::Cell(),
                  state.has_median_m() ? number_cell(state.median_m()) : v1::Cell(),
                  state.has_high_m() ? number_cell(state.high_m()) : v1::Cell()});
}

/// The next casting before and after the castings of a line.
void add_states(const v1::LineExperience& experience, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "experience", "the next casting of this recipe");
  const double resolution_m = shown_curl_m(experience.before().high_m());
  add_columns(table, {
                         text_column("known", "known"),
                         number_column("danger", "dangers", "1", 0.001),
                         number_column("danger_low", "5 % of plants below", "1", 0.001),
                         number_column("danger_high", "5 % above", "1", 0.001),
                         number_column("low", "curl 5 %", "m", resolution_m),
                         number_column("median", "50 %", "m", resolution_m),
                         number_column("high", "95 %", "m", resolution_m),
                     });

  add_state("the ranges of the data alone", experience.before(), table);
  if (experience.has_after()) add_state("the castings too", experience.after(), table);

  table.set_note(fmt::format(
      "surfaces of {} runs, which misjudge the danger of {} % of runs left out, and whose curl is "
      "off by {} mm",
      experience.runs(), percent(experience.misjudged()), mm(experience.curl_error_m())));
}

}  // namespace

void add_conditions(const v1::LineExperience& experience, v1::Judgement& judgement) {
  if (!experience.line().empty())
    judgement.add_sentences(fmt::format(
        "Line {} has {} casting{} of this recipe in {} record{}, {} of them with a "
        "measured curl.",
        experience.line(), experience.castings(), experience.castings() == 1 ? "" : "s",
        experience.records(), experience.records() == 1 ? "" : "s", experience.curls()));
  if (experience.assumed_sound())
    judgement.add_sentences(
        "It is assumed that this recipe is cast daily and soundly: 200 sound castings are added "
        "that nobody has recorded.");
  if (experience.castings_of_others() > 0)
    judgement.add_sentences(fmt::format("{} castings of other recipes are not used: {}.",
                                        experience.castings_of_others(),
                                        fmt::join(experience.other_recipes(), ", ")));
  if (experience.castings_without_meaning() > 0)
    judgement.add_sentences(
        fmt::format("{} castings of this recipe tell nothing here: they were followed or aborted, "
                    "or have cracked.",
                    experience.castings_without_meaning()));
  if (!experience.unexplained().empty())
    judgement.add_sentences(fmt::format(
        "Record {} fits no plant that the other castings leave possible, and hardly counts: check "
        "it (dccast line show {}).",
        fmt::join(experience.unexplained(), ", "), experience.line()));
}

void add_experience(const v1::LineExperience& experience, v1::Judgement& judgement) {
  add_conditions(experience, judgement);
  add_states(experience, judgement);
  if (!experience.has_after()) {
    judgement.add_sentences(
        "Fewer than 30 draws fit these castings: no answer rests on them. Check the records, or "
        "widen the ranges of the data.");
    return;
  }

  const auto& after = experience.after();
  judgement.add_sentences(fmt::format(
      "Of its next castings {} % are in danger, in 9 of 10 plants that are possible {} to {} %; "
      "before these castings it was {} %. This rests on {:.0f} effective draws.",
      share_text(after.danger()), share_text(after.danger_low()), share_text(after.danger_high()),
      share_text(experience.before().danger()), after.effective_draws()));
  if (after.has_low_m())
    judgement.add_sentences(fmt::format(
        "9 of 10 curl {} to {} mm; before it was {} to {} mm.", mm(after.low_m()),
        mm(after.high_m()), mm(experience.before().low_m()), mm(experience.before().high_m())));
}

}  // namespace dccast::judging
