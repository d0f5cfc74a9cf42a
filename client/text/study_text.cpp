#include "client/text/study_text.hpp"

#include <ctime>
#include <ostream>

#include <fmt/core.h>

#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal_guard.hpp"

namespace dccast::client {
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

}  // namespace dccast::client
