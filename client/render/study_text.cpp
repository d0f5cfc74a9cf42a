#include "client/render/study_text.hpp"

#include <algorithm>
#include <ostream>

#include "client/render/job_text.hpp"
#include "client/render/table.hpp"

namespace dccast::client::render {
namespace {

std::string row(const std::string& name, const std::string& value) {
  constexpr std::size_t width = 14;
  return name + std::string(width - std::min(width, name.size()), ' ') + value + "\n";
}

std::string joined(const google::protobuf::RepeatedPtrField<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + text;
  return all;
}

}  // namespace

std::string state_text(v1::StudyState state) {
  switch (state) {
    case v1::STUDY_RUNNING:
      return "running";
    case v1::STUDY_SUCCEEDED:
      return "succeeded";
    case v1::STUDY_FAILED:
      return "failed";
    case v1::STUDY_CANCELLED:
      return "cancelled";
    default:
      return "unknown";
  }
}

std::string plan_text(const v1::Study& study) {
  if (study.has_refinement()) return "refinement";
  if (study.has_mould()) return "mould";
  std::string keys;
  for (const auto& axis : study.sweep().axes()) keys += (keys.empty() ? "" : ", ") + axis.key();
  return "sweep of " + keys;
}

std::string progress_text(const v1::Study& study) {
  const int ended = study.succeeded() + study.failed() + study.cancelled();
  std::string text = std::to_string(ended) + " of " + std::to_string(study.runs()) + " runs";
  const auto add = [&text](int count, const char* what) {
    if (count > 0) text += ", " + std::to_string(count) + " " + what;
  };
  add(study.running(), "running");
  add(study.failed(), "failed");
  add(study.cancelled(), "cancelled");
  return text + ", " + fixed(100.0 * study.progress(), 0) + " %";
}

std::string study_sheet(const v1::Study& study) {
  std::string text = row("study", study.id()) + row("title", study.title()) +
                     row("plan", plan_text(study)) + row("state", state_text(study.state())) +
                     row("runs", progress_text(study)) +
                     row("created", time_text(study.create_time()));
  if (study.has_end_time()) text += row("ended", time_text(study.end_time()));
  if (!study.owner().empty()) text += row("owner", study.owner());
  if (!study.labels().empty()) text += row("labels", joined(study.labels()));
  if (!study.message().empty()) text += row("message", study.message());
  return text;
}

StudyProgress::~StudyProgress() {
  if (line_open_) stream_ << std::endl;
}

void StudyProgress::show(const v1::Study& study) {
  if (terminal_.interactive) {
    stream_ << "\r" << cut_to(progress_text(study), terminal_.columns - 1) << "\x1b[K"
            << std::flush;
    line_open_ = true;
    return;
  }
  const int tenth = static_cast<int>(10.0 * study.progress());
  if (tenth <= shown_tenth_ && study.state() == v1::STUDY_RUNNING) return;
  shown_tenth_ = tenth;
  stream_ << progress_text(study) << std::endl;
}

}  // namespace dccast::client::render
