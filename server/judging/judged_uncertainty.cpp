#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "proto/case_file/study_keys.hpp"
#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::JudgementPart;
using Values = google::protobuf::RepeatedField<double>;

constexpr double small_share = 0.01;  ///< of the variance

double last(const Values& values) {
  return values.empty() ? 0.0 : values[values.size() - 1];
}

std::vector<double> vector_of(const Values& values) {
  return {values.begin(), values.end()};
}

/// Axes with the largest figure first. @param figure  (axis)
template <class Figure>
std::vector<int> axes_by(const v1::Spread& spread, Figure figure) {
  // The last share is that of no axis: what the surface does not follow.
  std::vector<int> axes(static_cast<std::size_t>(std::max(0, spread.shares_size() - 1)));
  std::iota(axes.begin(), axes.end(), 0);
  std::ranges::stable_sort(axes, std::ranges::greater(), figure);
  return axes;
}

std::vector<int> axes_by_share_at_end(const v1::Spread& spread) {
  return axes_by(spread, [&](int axis) { return last(spread.shares(axis).total()); });
}

/// "± 0.36 mm", or "-0 +4.9 mm" where the sides differ.
std::string error_text(const v1::RelativeError& relative, double curl_m) {
  const case_file::CurlError error = case_file::curl_error(relative, curl_m);
  return figures::mm_errors(error.lower_m, error.upper_m, decimals_of(error.larger_m())) + " mm";
}

std::string datum(const v1::StudyResult& result, int axis) {
  return case_file::datum_of(result.study().sweep().axes(axis).key());
}

/// How the castings of a study end.
struct Ends {
  int whole = 0;     ///< to their end, with a curl that counts
  int lost = 0;      ///< bled out, melted through, or turned too far: no butt that a plant can use
  int beyond = 0;    ///< beyond validity: the curl is not known
  int unsolved = 0;  ///< for another reason; nothing is known of them
  int open = 0;      ///< to come

  int known() const { return whole + lost + beyond; }
};

/// Whether a run failed as the casting would, and not its computation.
bool is_lost_casting(const v1::StudyRun& run) {
  const v1::Finding& failure = run.failure();
  return run.state() == v1::FAILED &&
         (!failure.code().empty() || failure.kind() == v1::Finding::SHELL_MELTED_THROUGH ||
          failure.kind() == v1::Finding::MOTION_TOO_LARGE);
}

Ends count_ends(const v1::StudyResult& result) {
  Ends ends;
  for (const v1::StudyRun& run : result.runs()) {
    if (run.state() == v1::SUCCEEDED)
      ++(run.beyond_validity() ? ends.beyond : ends.whole);
    else if (is_lost_casting(run))
      ++ends.lost;
    else if (run.state() == v1::FAILED || run.state() == v1::CANCELLED)
      ++ends.unsolved;
    else
      ++ends.open;
  }
  return ends;
}

/// "6 bled out, melted through or turned, 1 ended beyond validity"; empty: none.
std::string losses_text(const Ends& ends) {
  std::vector<std::string> parts;
  if (ends.lost > 0)
    parts.push_back(fmt::format("{} bled out, melted through or turned", ends.lost));
  if (ends.beyond > 0) parts.push_back(fmt::format("{} ended beyond validity", ends.beyond));
  if (ends.unsolved > 0) parts.push_back(fmt::format("{} could not be computed", ends.unsolved));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_sentences(const StudyToJudge& study, v1::Judgement& judgement) {
  const v1::StudyResult& result = study.result;
  const v1::Spread& spread = result.spread();
  const Ends ends = count_ends(result);
  const std::string losses = losses_text(ends);
  if (!losses.empty())
    judgement.add_sentences(
        fmt::format("Of {} castings {}.", result.runs_size() - ends.open, losses));
  if (spread.time_s().empty()) {
    judgement.add_sentences(
        (is_under_way(result) ? "No answer yet: " : "The study has no answer: ") +
        result.spread_fault());
    return;
  }

  const double width = last(spread.high_m()) - last(spread.low_m());
  judgement.add_sentences(fmt::format(
      "At {:.0f} s 9 of 10 {} have {} to {} mm at the {}, half of them less than {} mm.",
      last(spread.time_s()), losses.empty() ? "castings" : "of the others",
      mm(last(spread.low_m())), mm(last(spread.high_m())), spread.monitor(),
      mm(last(spread.median_m()))));
  const auto error = study_study_mesh_error(result, spread.monitor());
  judgement.add_sentences(
      error
          ? fmt::format("Mesh and time steps add {}.", error_text(*error, last(spread.median_m())))
          : "What mesh and time steps add is not known for such a case: run dccast convergence.");
  // A casting that is lost ends in no band.
  if (spread.has_inside_band())
    judgement.add_sentences(
        fmt::format("{} % of{} castings end inside the accepted band.",
                    percent(spread.inside_band() * ends.whole / std::max(1, ends.known())),
                    losses.empty() ? "" : " all"));
  judgement.add_sentences(
      fmt::format("The response surface of {} runs is off by {} mm; that is in the figures.",
                  spread.runs(), mm(last(spread.surface_error_m()))));

  // What to measure first: the datum without which the range would be the narrowest.
  const auto axes = axes_by_share_at_end(spread);
  if (axes.empty() || !(last(spread.shares(axes.front()).total()) > small_share)) return;
  const double alone = last(spread.shares(axes.front()).first());
  judgement.add_sentences(fmt::format(
      "Measure {} first: were it known exactly, the {} mm between 5 and 95 % would be {} mm.",
      datum(result, axes.front()), mm(width), mm(std::sqrt(std::max(0.0, 1.0 - alone)) * width)));
}

/// The curl at some instants.
void add_history(const v1::Spread& spread, v1::Judgement& judgement) {
  constexpr int most_instants = 8;
  v1::Table& table =
      add_table(judgement, "history", "curl of the " + spread.monitor(), JudgementPart::TERMINAL);
  const double resolution_m = shown_curl_m(last(spread.high_m()));
  add_columns(table, {
                         number_column("time", "t", "s", 1.0),
                         number_column("cast_length", "cast", "m", 1e-3),
                         number_column("low", "5 %", "m", resolution_m),
                         number_column("median", "50 %", "m", resolution_m),
                         number_column("high", "95 %", "m", resolution_m),
                         number_column("surface_error", "surface off by", "m", resolution_m),
                     });

  // During the hold nothing curls.
  const auto& time_s = spread.time_s();
  const int first = static_cast<int>(std::ranges::upper_bound(time_s, 0.0) - time_s.begin());
  const int count = time_s.size() - first;
  const int rows = std::min(count, most_instants);
  for (int row = 1; row <= rows; ++row) {
    const int i = first + row * count / rows - 1;
    add_row(table, {number_cell(spread.time_s(i)), number_cell(spread.cast_length_m(i)),
                    number_cell(spread.low_m(i)), number_cell(spread.median_m(i)),
                    number_cell(spread.high_m(i)), number_cell(spread.surface_error_m(i))});
  }
}

/// The band of the data, and that of mesh and time steps apart.
void add_curl_chart(const v1::StudyResult& result, v1::Judgement& judgement) {
  const v1::Spread& spread = result.spread();
  v1::Chart& chart =
      add_chart(judgement, "curl", "what the data leave open of the " + spread.monitor(),
                {"time", "s", "curl", "m"});
  v1::Chart::Line& data =
      add_line(chart, "data, 5 to 95 %", vector_of(spread.time_s()), vector_of(spread.median_m()));
  *data.mutable_low() = spread.low_m();
  *data.mutable_high() = spread.high_m();

  const auto error = study_study_mesh_error(result, spread.monitor());
  if (!error) return;
  v1::Chart::Line& mesh = add_line(chart, "mesh and time steps", vector_of(spread.time_s()),
                                   vector_of(spread.median_m()));
  add_band(mesh, *error);
  // The band alone: its middle is the line above.
  for (double& value : *mesh.mutable_y()) value = std::numeric_limits<double>::quiet_NaN();
}

void add_shares_chart(const v1::StudyResult& result, v1::Judgement& judgement) {
  const v1::Spread& spread = result.spread();
  v1::Chart& chart = add_chart(judgement, "shares", "where it comes from",
                               {"time", "s", "share of the variance", "1"});
  const auto largest = [&](int axis) {
    const Values& total = spread.shares(axis).total();
    return total.empty() ? 0.0 : *std::ranges::max_element(total);
  };
  for (const int axis : axes_by(spread, largest)) {
    if (chart.lines_size() == most_lines) break;
    add_line(chart, datum(result, axis), vector_of(spread.index_time_s()),
             vector_of(spread.shares(axis).total()));
  }
}

/// Sobol's indices at the end, with twice the error of their sampling.
v1::Cell share_cell(const Values& share, const Values& error) {
  constexpr double least_error = 0.01;
  return number_cell(last(share), std::max(least_error, 2.0 * last(error)));
}

void add_shares(const v1::StudyResult& result, v1::Judgement& judgement) {
  constexpr int most_shares = 12;
  const v1::Spread& spread = result.spread();
  v1::Table& table = add_table(judgement, "shares", "what the variance at the end comes from");
  add_columns(table, {
                         text_column("datum", "datum"),
                         text_column("range", "range"),
                         number_column("alone", "alone", "1", 0.01),
                         number_column("with_others", "with others", "1", 0.01),
                     });
  for (const int column : {2, 3}) table.mutable_columns(column)->set_has_error(true);

  const auto axes = axes_by_share_at_end(spread);
  for (const int axis : axes) {
    const v1::Spread::Share& share = spread.shares(axis);
    if (table.rows_size() == most_shares || last(share.total()) < small_share) break;
    add_row(table, {text_cell(datum(result, axis)),
                    text_cell(case_file::range_of(result.study().sweep().axes(axis))),
                    share_cell(share.first(), share.first_error()),
                    share_cell(share.total(), share.total_error())});
  }
  if (const int rest = static_cast<int>(axes.size()) - table.rows_size(); rest > 0)
    table.set_note(fmt::format("{} more data, with less than these", rest));
  if (!spread.shares().empty())
    add_row(table, {text_cell("what the response surface does not follow"),
                    {},
                    number_cell(last(spread.shares().rbegin()->total()))});
}

/// What the castings of a line say, and what to measure next given them.
void add_line(const v1::StudyResult& result, v1::Judgement& judgement) {
  if (!result.experience_fault().empty())
    judgement.add_sentences("Nothing is said of the line: " + result.experience_fault() + ".");
  if (!result.has_experience()) return;

  add_experience(result.experience(), judgement);
  const auto& told = result.experience().told();
  const auto most = std::ranges::max_element(told);
  if (most == told.end() || !(*most > 2.0 * small_share)) return;
  judgement.add_sentences(fmt::format(
      "Given these castings, measure {} first: it still holds {} % of the variance of the curl.",
      datum(result, static_cast<int>(most - told.begin())), percent(*most)));
}

}  // namespace

void judge_uncertainty(const StudyToJudge& study, v1::Judgement& judgement) {
  add_sentences(study, judgement);
  if (!study.result.spread().time_s().empty()) {
    add_history(study.result.spread(), judgement);
    add_curl_chart(study.result, judgement);
    add_shares_chart(study.result, judgement);
    add_shares(study.result, judgement);
  }
  add_line(study.result, judgement);
  add_lost_runs(study.result, JudgementPart::ANYWHERE, judgement);
}

}  // namespace dccast::judging
