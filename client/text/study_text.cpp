#include "client/text/study_text.hpp"

#include <algorithm>
#include <ctime>
#include <ostream>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

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

using Rows = std::vector<std::vector<std::string>>;

std::string millimetres(double metres) {
  return fixed(1e3 * metres, 3);
}

/// A figure, with a mark if it is beyond validity.
std::string marked(std::string figure, bool valid) {
  return valid ? figure : figure + " !";
}

/// ", about 3 min left" at the pace so far; empty before there is one and after the end.
std::string left_text(const v1::Study& study) {
  constexpr double least_progress = 0.02;
  if (study.state() != v1::STUDY_RUNNING || study.progress() < least_progress) return {};
  const double passed = static_cast<double>(std::time(nullptr) - study.create_time().seconds());
  return ", about " + duration_text(passed * (1.0 - study.progress()) / study.progress()) + " left";
}

/// Curl at the end of a level; "-" where it has none.
std::string end_curl(const StudyLevel& level, std::size_t monitor) {
  if (!level.succeeded() || monitor >= level.end_curl_m.size()) return "-";
  return marked(millimetres(level.end_curl_m[monitor]), !level.ends_beyond_validity());
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
  const std::string count = std::to_string(study.sweep().axes_size());
  if (study.sweep().purpose() == v1::SweepPlan::UNCERTAINTY)
    return "uncertainty, " + count + " data";
  if (study.sweep().purpose() == v1::SweepPlan::SENSITIVITY)
    return "sensitivity, " + count + " keys";
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
    stream_ << "\r" << cut_to(progress_text(study) + left_text(study), terminal_.columns - 1)
            << "\x1b[K" << std::flush;
    line_open_ = true;
    return;
  }
  const int tenth = static_cast<int>(10.0 * study.progress());
  if (tenth <= shown_tenth_ && study.state() == v1::STUDY_RUNNING) return;
  shown_tenth_ = tenth;
  stream_ << progress_text(study) << left_text(study) << std::endl;
}

std::vector<std::string> monitor_names(const Study& study) {
  return study.succeeded().empty() ? std::vector<std::string>{} : study.monitor_names;
}

Rows level_rows(const Study& study) {
  Rows rows;
  for (const StudyLevel& level : study.levels) {
    const v1::StepReport& last = level.job.last_step();
    auto& row = rows.emplace_back();
    row = {std::to_string(level.refinement), std::to_string(last.nodes()),
           fixed(last.solver_s(), 1), full_state_text(level.job)};
    for (std::size_t k = 0; k < monitor_names(study).size(); ++k) row.push_back(end_curl(level, k));
  }
  return rows;
}

Rows limit_rows(const Study& study) {
  Rows rows{{"order", "", "", ""},
            {"limit", "", "", ""},
            {"+-", "", "", ""},
            {"+- at most", "", "", ""},
            {"at s", "", "", ""}};
  for (const MonitorStudy& monitor : study.monitors) {
    const CurveLimit& limit = monitor.limit;
    const std::size_t worst = monitor.least_certain();
    rows[0].push_back(limit.order ? fixed(*limit.order, 2) : "none");
    const bool valid = study.valid_at(study.time_s.back());
    rows[1].push_back(marked(millimetres(limit.value_m.back()), valid));
    rows[2].push_back(marked(millimetres(limit.uncertainty_m.back()), valid));
    rows[3].push_back(
        marked(millimetres(limit.uncertainty_m[worst]), study.valid_at(study.time_s[worst])));
    rows[4].push_back(fixed(study.time_s[worst], 2));
  }
  return study.monitors.empty() ? Rows{} : rows;
}

std::string validity_note(const Study& study) {
  if (!study.valid_until_s) return {};
  return std::string("! ") + beyond_validity + ": from " + fixed(*study.valid_until_s, 2) +
         " s on the model of at least one level is not valid";
}

std::string study_table(const Study& study) {
  std::vector<std::string> headings{">refinement", ">nodes", ">solver s", "state"};
  for (const std::string& name : monitor_names(study)) headings.push_back(">" + name + " mm");
  Table table(headings);
  for (auto& row : level_rows(study)) table.add(std::move(row));
  for (auto& row : limit_rows(study)) table.add(std::move(row));
  const std::string note = validity_note(study);
  return table.text() + (note.empty() ? note : note + "\n");
}

}  // namespace dccast::client::render
