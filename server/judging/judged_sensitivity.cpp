#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/case_file/study_keys.hpp"
#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::JudgementPart;

/// What one end of an axis does to the curl at the end.
struct End {
  std::optional<double> difference_m;  ///< to the case itself; empty: no valid run
  bool failed = false;
};

struct AxisEffect {
  int axis = 0;
  End low, high;

  double largest_m() const {
    return std::max(std::abs(low.difference_m.value_or(0.0)),
                    std::abs(high.difference_m.value_or(0.0)));
  }
};

struct Effects {
  std::optional<double> base_m;     ///< curl of the case itself; empty: no valid run
  std::optional<double> error_m;    ///< to which a small difference of two runs is known
  std::vector<AxisEffect> effects;  ///< largest first

  /// Below it a curl does not respond: a fiftieth of a millimetre, a tenth of the error.
  double negligible_m() const { return std::max(2e-5, 0.1 * error_m.value_or(0.0)); }
  bool responds(const AxisEffect& effect) const {
    const bool complete = effect.low.difference_m && effect.high.difference_m;
    return !complete || effect.largest_m() >= negligible_m();
  }
};

/// The curl at the end; empty where the run is no answer.
std::optional<double> end_curl(const v1::StudyRun& run, int monitor) {
  if (!is_valid(run) || monitor >= run.end_curl_m_size()) return std::nullopt;
  const double curl_m = run.end_curl_m(monitor);
  return std::isfinite(curl_m) ? std::optional(curl_m) : std::nullopt;
}

/// The axis that a run moves, -1 for the case itself.
int moved_axis(const v1::StudyRun& run) {
  for (int axis = 0; axis < run.values_size(); ++axis)
    if (!run.values(axis).empty()) return axis;
  return -1;
}

Effects find_effects(const StudyToJudge& study) {
  const v1::StudyResult& result = study.result;
  const auto& axes = result.study().sweep().axes();
  Effects found;
  for (int axis = 0; axis < axes.size(); ++axis) found.effects.push_back({axis, {}, {}});
  for (const v1::StudyRun& run : result.runs())
    if (moved_axis(run) < 0) found.base_m = end_curl(run, study.monitor);

  for (const v1::StudyRun& run : result.runs()) {
    const int axis = moved_axis(run);
    if (axis < 0) continue;
    AxisEffect& effect = found.effects[static_cast<std::size_t>(axis)];
    End& end = run.values(axis) == axes[axis].values(0) ? effect.low : effect.high;
    const auto curl_m = end_curl(run, study.monitor);
    end.failed = !curl_m;
    if (curl_m && found.base_m) end.difference_m = *curl_m - *found.base_m;
  }
  std::ranges::stable_sort(found.effects, std::ranges::greater(), &AxisEffect::largest_m);
  if (study.difference_error && found.base_m)
    found.error_m = *study.difference_error * std::abs(*found.base_m);
  return found;
}

/// An effect of a shift is not one of the key itself.
std::string name_of(const v1::SweepPlan::Axis& axis) {
  return axis.key().ends_with(".shift") ? axis.key() : case_file::datum_of(axis.key());
}

v1::Cell end_cell(const End& end) {
  if (end.difference_m) return number_cell(*end.difference_m);
  return end.failed ? code_cell("fails") : v1::Cell();
}

void add_effect_table(const v1::StudyResult& result, const std::string& key,
                      const std::string& heading, JudgementPart::Place place,
                      const std::vector<AxisEffect>& effects, double base_m,
                      v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, key, heading, place);
  add_columns(table, {
                         text_column("kind", "kind"),
                         text_column("name", "key"),
                         text_column("range", "range"),
                     });
  for (const char* end : {"low", "high"}) {
    v1::Table::Column& column = *table.add_columns();
    column = number_column(end, end, "m", shown_curl_m(base_m));
    column.set_is_signed(true);
    column.set_has_bars(true);
  }
  add_columns(table, {text_column("key", "")});

  for (const AxisEffect& effect : effects) {
    const v1::SweepPlan::Axis& axis = result.study().sweep().axes(effect.axis);
    add_row(table, {code_cell(case_file::is_lever(axis.key()) ? "lever" : "datum"),
                    text_cell(name_of(axis)), text_cell(case_file::range_of(axis)),
                    end_cell(effect.low), end_cell(effect.high), text_cell(axis.key())});
  }
}

/// What the effects are differences to.
void add_case_itself(const std::string& monitor, const Effects& found, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "case_itself", "the case itself", JudgementPart::PAGE);
  add_columns(table, {
                         text_column("monitor", "monitor"),
                         number_column("curl", "curl at the end", "m", shown_curl_m(*found.base_m)),
                         number_column("difference_error", "error of a small difference", "m",
                                       shown_curl_m(*found.base_m)),
                     });
  add_row(table, {text_cell(monitor), number_cell(*found.base_m),
                  found.error_m ? number_cell(*found.error_m) : v1::Cell()});
}

}  // namespace

void judge_sensitivity(const StudyToJudge& study, v1::Judgement& judgement) {
  const v1::StudyResult& result = study.result;
  const Effects found = find_effects(study);
  if (!found.base_m) {
    judgement.add_sentences("The case itself has no valid run: there is nothing to compare with.");
    add_lost_runs(result, JudgementPart::ANYWHERE, judgement);
    return;
  }

  // Levers of the plant first; a terminal leaves out what does not matter.
  std::vector<AxisEffect> all = found.effects;
  std::stable_partition(all.begin(), all.end(), [&](const AxisEffect& effect) {
    return case_file::is_lever(result.study().sweep().axes(effect.axis).key());
  });
  std::vector<AxisEffect> responding;
  std::ranges::copy_if(all, std::back_inserter(responding),
                       [&](const AxisEffect& effect) { return found.responds(effect); });
  const std::string& monitor = result.monitors(study.monitor);
  add_case_itself(monitor, found, judgement);
  add_effect_table(
      result, "responding",
      fmt::format("curl of the {} at the end: {} mm; change at the two ends of each range", monitor,
                  mm(*found.base_m)),
      JudgementPart::TERMINAL, responding, *found.base_m, judgement);
  add_effect_table(result, "effects",
                   fmt::format("change of the curl of the {} at the end, {} mm in the case itself",
                               monitor, mm(*found.base_m)),
                   JudgementPart::PAGE, all, *found.base_m, judgement);
  add_lost_runs(result, JudgementPart::ANYWHERE, judgement);

  judgement.add_sentences(
      found.error_m ? fmt::format("A small difference is known to ± {} mm: mesh and time steps.",
                                  mm(*found.error_m))
                    : "The error of a difference has not been measured for such a case.");
  std::vector<std::string> without_response;
  for (const AxisEffect& effect : found.effects)
    if (!found.responds(effect))
      without_response.push_back(name_of(result.study().sweep().axes(effect.axis)));
  if (!without_response.empty())
    judgement.add_sentences(
        fmt::format("This model does not respond to {}.", joined(without_response, ", ")));
}

}  // namespace dccast::judging
