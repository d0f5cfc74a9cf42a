#include "server/judging/judged_study.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::JudgementPart;

/// "SHELL_MELTED_THROUGH" as a code of a cell.
std::string lower_case(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// "61 valid, 2 beyond validity, 1 failed or cancelled".
std::string count_text(const v1::StudyResult& result) {
  int valid = 0;
  int beyond = 0;
  int failed = 0;
  int open = 0;
  for (const v1::StudyRun& run : result.runs()) {
    if (run.state() == v1::FAILED || run.state() == v1::CANCELLED)
      ++failed;
    else if (run.state() != v1::SUCCEEDED)
      ++open;
    else
      ++(run.beyond_validity() ? beyond : valid);
  }

  std::string text = fmt::format("{} valid", valid);
  if (beyond > 0) text += fmt::format(", {} beyond validity", beyond);
  if (failed > 0) text += fmt::format(", {} failed or cancelled", failed);
  if (open > 0) text += fmt::format(", {} to come", open);
  return text;
}

/// "2 bleed_out, 1 solve failed": why runs failed.
std::string loss_text(const v1::StudyResult& result) {
  std::map<std::string, int> reasons;
  for (const v1::StudyRun& run : result.runs()) {
    if (!run.has_failure()) continue;
    const v1::Failure& failure = run.failure();
    std::string kind = lower_case(v1::Failure_Kind_Name(failure.kind()));
    std::ranges::replace(kind, '_', ' ');
    ++reasons[failure.finding().empty() ? kind : failure.finding()];
  }
  return joined(reasons, ", ", [](const auto& reason) {
    return fmt::format("{} {}", reason.second, reason.first);
  });
}

/// Every run with its values and its curls at the end.
void add_runs(const v1::StudyResult& result, v1::Judgement& judgement) {
  const bool refined = result.study().has_refinement();
  const bool has_errors =
      std::ranges::any_of(result.runs(), &v1::StudyRun::has_relative_curl_error);
  v1::Table& table = add_table(judgement, "runs", "");
  *table.add_columns() = number_column("run", "run", "", 1.0);
  if (refined) *table.add_columns() = number_column("refinement", "refinement", "", 1.0);
  for (const auto& axis : result.study().sweep().axes())
    *table.add_columns() = text_column(axis.key(), axis.key());
  for (const std::string& monitor : result.monitors()) {
    *table.add_columns() = number_column(monitor, monitor, "m", 1e-6);
    table.mutable_columns()->rbegin()->set_has_error(has_errors);
  }
  *table.add_columns() = text_column("outcome", "outcome");
  *table.add_columns() = number_column("findings", "findings", "", 1.0);
  *table.add_columns() = number_column("solver", "solver", "s", 0.1);
  *table.add_columns() = text_column("job", "");

  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    v1::Table::Row& row = *table.add_rows();
    *row.add_cells() = number_cell(i + 1);
    if (refined) *row.add_cells() = number_cell(run.refinement());
    for (const auto& value : run.values()) *row.add_cells() = text_cell(value);
    for (int monitor = 0; monitor < result.monitors_size(); ++monitor) {
      v1::Cell& cell = *row.add_cells();
      if (monitor >= run.end_curl_m_size()) continue;
      const double curl_m = run.end_curl_m(monitor);
      cell = number_cell(curl_m, run.has_relative_curl_error()
                                     ? std::optional(run.relative_curl_error() * std::abs(curl_m))
                                     : std::nullopt);
    }
    *row.add_cells() = code_cell(outcome_code(run));
    *row.add_cells() = number_cell(static_cast<double>(std::ranges::count_if(
        run.findings(), [](const auto& f) { return f.severity() > v1::Finding::NOTE; })));
    *row.add_cells() = number_cell(run.solver_s());
    *row.add_cells() = text_cell(run.job());
  }
}

/// What the curls of a refinement study tend to at the end, and where they are least certain.
void add_limits(const v1::StudyResult& result, v1::Judgement& judgement) {
  if (result.limits().empty()) return;
  v1::Table& table = add_table(judgement, "limits", "limits of the curls at the end");
  *table.add_columns() = text_column("monitor", "monitor");
  *table.add_columns() = number_column("order", "order", "", 0.01);
  *table.add_columns() = number_column("limit", "limit", "m", 1e-6);
  *table.add_columns() = number_column("largest_error", "largest error", "m", 1e-6);
  *table.add_columns() = number_column("at", "at", "s", 0.01);
  table.mutable_columns(2)->set_has_error(true);
  if (result.has_valid_until_s())
    table.set_note(fmt::format("from {:.2f} s on the model of at least one level is not valid",
                               result.valid_until_s()));

  for (const v1::StudyResult::Limit& limit : result.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    const int last = curve.curl_m_size() - 1;
    if (last < 0) continue;
    int worst = 0;
    for (int i = 1; i <= last; ++i)
      if (!(curve.uncertainty_m(i) <= curve.uncertainty_m(worst)) &&
          std::isfinite(curve.uncertainty_m(i)))
        worst = i;
    add_row(table, {text_cell(curve.monitor()),
                    limit.has_order() ? number_cell(limit.order()) : code_cell("none"),
                    number_cell(curve.curl_m(last), curve.uncertainty_m(last)),
                    number_cell(curve.uncertainty_m(worst)), number_cell(curve.time_s(worst))});

    v1::Chart& chart = add_chart(judgement, "limit", "limit of the curl of " + curve.monitor(),
                                 {"time", "s", "curl", "m"});
    v1::Chart::Line& line = *chart.add_lines();
    line.set_name("limit");
    *line.mutable_x() = curve.time_s();
    *line.mutable_y() = curve.curl_m();
    for (int i = 0; i <= last; ++i) {
      line.add_low(curve.curl_m(i) - curve.uncertainty_m(i));
      line.add_high(curve.curl_m(i) + curve.uncertainty_m(i));
    }
    if (result.has_valid_until_s()) chart.set_beyond_x(result.valid_until_s());
  }
}

}  // namespace

double shown_curl_m(double curl_m) {
  constexpr double small_m = 1e-2;
  return std::abs(curl_m) < small_m ? 1e-5 : 1e-4;
}

std::string mm(double metres) {
  return fmt::format("{:.{}f}", 1e3 * metres, std::abs(metres) < 1e-3 ? 2 : 1);
}

std::string percent(double share) {
  return fmt::format("{:.0f}", 100.0 * share);
}

bool is_valid(const v1::StudyRun& run) {
  return run.state() == v1::SUCCEEDED && !run.beyond_validity();
}

std::string outcome_code(const v1::StudyRun& run) {
  if (run.beyond_validity()) return "beyond_validity";
  if (run.has_failure()) return lower_case(v1::Failure_Kind_Name(run.failure().kind()));
  if (run.job().empty() && run.state() == v1::QUEUED) return "waiting";
  return lower_case(v1::JobState_Name(run.state()));
}

void add_lost_runs(const v1::StudyResult& result, JudgementPart::Place place,
                   v1::Judgement& judgement) {
  const auto is_lost = [](const v1::StudyRun& run) { return !is_valid(run); };
  if (std::ranges::none_of(result.runs(), is_lost)) return;

  v1::Table& table =
      add_table(judgement, "lost_runs", "runs that the figures do not rest on", place);
  *table.add_columns() = number_column("run", "run", "", 1.0);
  *table.add_columns() = text_column("values", "values");
  *table.add_columns() = text_column("outcome", "outcome");
  *table.add_columns() = text_column("message", "why");
  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    if (!is_lost(run)) continue;
    std::string values;
    for (int axis = 0; axis < run.values_size(); ++axis)
      if (!run.values(axis).empty())
        values += fmt::format("{}{} = {}", values.empty() ? "" : "; ",
                              result.study().sweep().axes(axis).key(), run.values(axis));
    add_row(table, {number_cell(i + 1), text_cell(values), code_cell(outcome_code(run)),
                    text_cell(run.failure().message())});
  }
}

const v1::StudyRun* first_valid_run(const v1::StudyResult& result) {
  const auto found = std::ranges::find_if(result.runs(), is_valid);
  return found == result.runs().end() ? nullptr : &*found;
}

v1::Judgement judge_study(const StudyToJudge& study) {
  const v1::StudyResult& result = study.result;
  v1::Judgement judgement;
  const std::string losses = loss_text(result);
  judgement.set_heading(fmt::format("{} runs: {}{}", result.runs_size(), count_text(result),
                                    losses.empty() ? "" : fmt::format(" ({})", losses)));

  const auto purpose = result.study().sweep().purpose();
  if (result.study().has_recipe()) {
    judge_recipe(result, judgement);
  } else if (purpose == v1::SweepPlan::UNCERTAINTY) {
    judge_uncertainty(study, judgement);
  } else if (purpose == v1::SweepPlan::SENSITIVITY) {
    judge_sensitivity(study, judgement);
  } else {
    add_runs(result, judgement);
    add_limits(result, judgement);
  }
  return judgement;
}

}  // namespace dccast::judging
