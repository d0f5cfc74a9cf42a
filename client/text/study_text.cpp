#include "client/text/study_text.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <ostream>

#include <fmt/core.h>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal_guard.hpp"
#include "proto/case_file/key_place.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::client::render {
namespace {

/// ", about 3 min left" by the pace so far; empty without a pace and after the end.
std::string left_text(const v1::Study& study) {
  constexpr double least_progress = 0.02;
  if (study.state() != v1::STUDY_RUNNING || study.progress() < least_progress) return {};
  const double passed = static_cast<double>(std::time(nullptr) - study.create_time().seconds());
  return ", about " + duration_text(passed * (1.0 - study.progress()) / study.progress()) + " left";
}

}  // namespace

std::string state_text(const v1::Study& study) {
  switch (study.state()) {
    case v1::STUDY_RUNNING:
      return "running";
    case v1::STUDY_CANCELLED:
      return "cancelled";
    case v1::STUDY_SUCCEEDED:
    case v1::STUDY_FAILED:
      return study.succeeded() > 0 ? "answered" : "no answer";
    default:
      return "unknown";
  }
}

std::string plan_text(const v1::Study& study) {
  if (study.has_refinement()) return "refinement";
  if (study.has_mould()) return "mould";
  if (study.has_recipe())
    return "recipe, " + std::to_string(study.recipe().numbers_size()) + " numbers";
  if (study.has_remedy()) return "remedy of job " + study.remedy().job();
  if (study.has_levers()) return "levers, moved while it is cast";
  const std::string count = std::to_string(study.sweep().axes_size());
  if (study.sweep().purpose() == v1::SweepPlan::UNCERTAINTY)
    return "uncertainty, " + count + " data";
  if (study.sweep().purpose() == v1::SweepPlan::SENSITIVITY)
    return "sensitivity, " + count + " keys";
  if (study.sweep().purpose() == v1::SweepPlan::CALIBRATION)
    return study.sweep().further_of().empty()
               ? "calibration, " + count + " keys"
               : "further runs of calibration " + study.sweep().further_of();
  return "sweep of " + joined(study.sweep().axes(), ", ", &v1::SweepPlan::Axis::key);
}

std::string runs_text(const v1::Study& study) {
  const int ended = study.succeeded() + study.failed() + study.cancelled();
  std::string text = fmt::format("{} of {} runs", ended, study.runs());
  const auto add = [&text](int count, const char* state) {
    if (count > 0) text += fmt::format(", {} {}", count, state);
  };
  add(study.running(), "running");
  add(study.failed(), "failed");
  add(study.cancelled(), "cancelled");
  return text;
}

std::string progress_text(const v1::Study& study) {
  return runs_text(study) + ", " + fixed(100.0 * study.progress(), 0) + " %";
}

std::string study_sheet(const v1::Study& study) {
  std::string text = sheet_line("study", study.id()) + sheet_line("title", study.title()) +
                     sheet_line("plan", plan_text(study)) + sheet_line("state", state_text(study)) +
                     sheet_line("runs", progress_text(study)) +
                     sheet_line("created", time_text(study.create_time()));
  if (study.has_end_time()) text += sheet_line("ended", time_text(study.end_time()));
  if (!study.owner().empty()) text += sheet_line("owner", study.owner());
  if (!study.labels().empty()) text += sheet_line("labels", joined(study.labels()));
  if (!study.message().empty()) text += sheet_line("message", study.message());
  return text;
}

StudyProgress::~StudyProgress() {
  if (line_open_) stream_ << std::endl;
}

void StudyProgress::show(const v1::Study& study) {
  if (terminal_.interactive) {
    stream_ << begin_of_line
            << cut_to(progress_text(study) + left_text(study), terminal_.columns - 1)
            << clear_rest_of_line << std::flush;
    line_open_ = true;
    return;
  }
  const int tenth = static_cast<int>(10.0 * study.progress());
  if (tenth <= shown_tenth_ && study.state() == v1::STUDY_RUNNING) return;
  shown_tenth_ = tenth;
  stream_ << progress_text(study) << left_text(study) << std::endl;
}

namespace {

/// "_m_per_s": suffix for the unit of a key's numbers; "_factor" and "_si" where they have none.
std::string si_suffix(const std::string& key) {
  if (key.ends_with(".scale")) return "_factor";
  const auto* const field = case_file::field_at(v1::Case(), key);
  const auto suffix =
      field == nullptr ? std::nullopt : case_file::unit_suffix(case_file::key_of(*field).unit());
  return suffix && !suffix->empty() ? *suffix : "_si";
}

std::string csv_number(double value) {
  return std::isfinite(value) ? case_file::number_text(value) : "";
}

std::string csv_head(const v1::StudyResult& result) {
  std::string head = "run,job,state";
  for (const auto& axis : result.study().sweep().axes())
    head += "," + csv_text(axis.key()) + "," + csv_text(axis.key() + si_suffix(axis.key()));
  for (const std::string& monitor : result.monitors())
    for (const char* figure : {"_end_curl_m", "_lower_error_m", "_upper_error_m"})
      head += "," + csv_text(monitor + figure);
  return head + ",solver_s,beyond_validity,findings,failure\n";
}

/// Error of mesh and time steps of a run's curl; NaN if unknown.
case_file::CurlError mesh_error(const v1::StudyRun& run, double curl_m) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  return run.has_mesh_error() ? case_file::curl_error(run.mesh_error(), curl_m)
                              : case_file::CurlError{unknown, unknown};
}

std::string csv_row(const v1::StudyRun& run, int number) {
  std::string row = fmt::format("{},{},{}", number, run.job(), v1::JobState_Name(run.state()));
  for (int i = 0; i < run.values_size(); ++i)
    row += "," + csv_text(run.values(i)) + "," + csv_number(run.numbers(i));
  for (const double curl_m : run.end_curl_m()) {
    const case_file::CurlError error = mesh_error(run, curl_m);
    for (const double figure : {curl_m, error.lower_m, error.upper_m})
      row += "," + csv_number(figure);
  }
  return row + fmt::format(",{},{:d},{},{}\n", csv_number(run.solver_s()), run.beyond_validity(),
                           joined(run.findings(), " ", &v1::Finding::code),
                           csv_text(run.failure().message()));
}

}  // namespace

std::string sweep_csv(const v1::StudyResult& result) {
  std::string text = csv_head(result);
  for (int i = 0; i < result.runs_size(); ++i) text += csv_row(result.runs(i), i + 1);
  return text;
}

}  // namespace dccast::client::render
