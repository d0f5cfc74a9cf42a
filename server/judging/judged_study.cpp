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
    const v1::Finding& failure = run.failure();
    std::string kind = lower_case(v1::Finding_Kind_Name(failure.kind()));
    std::ranges::replace(kind, '_', ' ');
    ++reasons[failure.code().empty() ? kind : failure.code()];
  }
  return joined(reasons, ", ", [](const auto& reason) {
    return fmt::format("{} {}", reason.second, reason.first);
  });
}

/// What mesh and time steps leave uncertain of the curl of a monitor; empty: not known.
std::optional<case_file::CurlError> mesh_error(const v1::StudyRun& run, int monitor) {
  if (monitor >= run.end_upper_error_m_size() || !std::isfinite(run.end_upper_error_m(monitor)))
    return std::nullopt;
  return case_file::CurlError{run.end_lower_error_m(monitor), run.end_upper_error_m(monitor)};
}

/// Smallest difference worth showing of the curls of a monitor [m]: the smallest of their errors is
/// shown with two digits, and no curl finer than a hundredth of a millimetre. Levels of a
/// refinement differ by less.
double shown_end_curl_m(const v1::StudyResult& result, int monitor) {
  if (result.study().has_refinement()) return 1e-6;

  double least_m = 0.0;
  for (const v1::StudyRun& run : result.runs()) {
    if (monitor >= run.end_curl_m_size()) continue;
    const double error_m = mesh_error(run, monitor).value_or(case_file::CurlError{}).larger_m();
    if (error_m > 0.0 && (least_m == 0.0 || error_m < least_m)) least_m = error_m;
  }
  return 1e-3 * std::pow(10.0, -figures::mm_decimals(least_m));
}

void add_run_columns(const v1::StudyResult& result, v1::Table& table) {
  const bool has_errors = std::ranges::any_of(
      result.runs(), [](const v1::StudyRun& run) { return !run.end_upper_error_m().empty(); });
  add_columns(table, {number_column("run", "run", "", 1.0)});

  if (result.study().has_refinement()) {
    add_columns(table, {number_column("refinement", "refinement", "", 1.0),
                        number_column("nodes", "nodes", "", 1.0)});
  }
  if (result.study().has_levers()) {
    add_columns(table, {text_column("change", "change"), number_column("from", "from", "s", 1.0)});
  }

  for (const auto& axis : result.study().sweep().axes())
    add_columns(table, {text_column(axis.key(), axis.key())});
  for (int monitor = 0; monitor < result.monitors_size(); ++monitor) {
    const std::string& name = result.monitors(monitor);
    add_columns(table, {number_column(name, name, "m", shown_end_curl_m(result, monitor))});
    table.mutable_columns()->rbegin()->set_has_error(has_errors);
  }

  add_columns(table, {
                         number_column("findings", "findings", "", 1.0),
                         number_column("solver", "solver", "s", 0.1),
                         text_column("outcome", "outcome"),
                         text_column("job", ""),
                     });
}

}  // namespace

double shown_curl_m(double curl_m) {
  constexpr double small_m = 1e-2;
  return std::abs(curl_m) < small_m ? 1e-5 : 1e-4;
}

int decimals_of(double metres) {
  return std::abs(metres) < 1e-3 ? 2 : 1;
}

std::string mm(double metres) {
  return figures::mm(metres, decimals_of(metres));
}

std::string percent(double share) {
  return fmt::format("{:.0f}", 100.0 * share);
}

bool is_valid(const v1::StudyRun& run) {
  return run.state() == v1::SUCCEEDED && !run.beyond_validity();
}

std::string outcome_code(const v1::StudyRun& run) {
  if (run.beyond_validity()) return "beyond_validity";
  if (run.has_failure()) return lower_case(v1::Finding_Kind_Name(run.failure().kind()));
  if (run.job().empty() && run.state() == v1::QUEUED) return "waiting";
  return lower_case(v1::JobState_Name(run.state()));
}

bool is_under_way(const v1::StudyResult& result) {
  return std::ranges::any_of(result.runs(), [](const v1::StudyRun& run) {
    return run.state() != v1::SUCCEEDED && run.state() != v1::FAILED &&
           run.state() != v1::CANCELLED;
  });
}

void add_lost_runs(const v1::StudyResult& result, JudgementPart::Place place,
                   v1::Judgement& judgement) {
  const auto is_lost = [](const v1::StudyRun& run) { return !is_valid(run); };
  if (std::ranges::none_of(result.runs(), is_lost)) return;

  v1::Table& table =
      add_table(judgement, "lost_runs", "runs that the figures do not rest on", place);
  add_columns(table, {
                         number_column("run", "run", "", 1.0),
                         text_column("values", "values"),
                         text_column("outcome", "outcome"),
                         text_column("message", "why"),
                     });
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

void add_runs(const v1::StudyResult& result, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "runs", "");
  add_run_columns(result, table);

  for (const v1::StudyRun& run : result.runs()) {
    v1::Table::Row& row = *table.add_rows();
    *row.add_cells() = number_cell(table.rows_size());
    if (result.study().has_refinement()) {
      *row.add_cells() = number_cell(run.refinement());
      *row.add_cells() = number_cell(static_cast<double>(run.nodes()));
    }
    if (result.study().has_levers()) {
      const v1::LeverStep& step = run.lever_step();
      *row.add_cells() = text_cell(run.has_lever_step() ? step.words() : "the plan");
      *row.add_cells() = step.has_from_s() ? number_cell(step.from_s()) : v1::Cell();
    }
    for (const auto& value : run.values()) *row.add_cells() = text_cell(value);
    for (int monitor = 0; monitor < result.monitors_size(); ++monitor) {
      v1::Cell& cell = *row.add_cells();
      if (monitor >= run.end_curl_m_size()) continue;
      cell = curl_cell(run.end_curl_m(monitor), mesh_error(run, monitor));
    }

    const auto findings = std::ranges::count_if(run.findings(), [](const v1::Finding& finding) {
      return finding.severity() > v1::Finding::NOTE;
    });
    *row.add_cells() = number_cell(static_cast<double>(findings));
    *row.add_cells() = number_cell(run.solver_s());
    *row.add_cells() = code_cell(outcome_code(run));
    *row.add_cells() = text_cell(run.job());
  }
}

const v1::StudyRun* first_valid_run(const v1::StudyResult& result) {
  const auto found = std::ranges::find_if(result.runs(), is_valid);
  return found == result.runs().end() ? nullptr : &*found;
}

std::optional<v1::RelativeError> study_study_mesh_error(const v1::StudyResult& result,
                                                        const std::string& monitor) {
  const v1::StudyRun* const run = first_valid_run(result);
  if (run == nullptr || !run->has_mesh_error()) return std::nullopt;

  // A run has no error at its end where none was measured.
  const int number = monitor_of(result, monitor);
  return number >= 0 && mesh_error(*run, number) ? std::optional(run->mesh_error()) : std::nullopt;
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
  } else if (result.study().has_mould()) {
    judge_mould(result, judgement);
  } else if (result.study().has_remedy()) {
    judge_remedy(study, judgement);
  } else if (result.study().has_levers()) {
    add_runs(result, judgement);
  } else if (purpose == v1::SweepPlan::UNCERTAINTY) {
    judge_uncertainty(study, judgement);
  } else if (purpose == v1::SweepPlan::SENSITIVITY) {
    judge_sensitivity(study, judgement);
  } else if (result.has_calibration() || !result.calibration_fault().empty()) {
    judge_calibration(result, judgement);
  } else if (result.study().has_refinement()) {
    judge_refinement(result, judgement);
  } else {
    judge_sweep(result, judgement);
  }
  return judgement;
}

}  // namespace dccast::judging
