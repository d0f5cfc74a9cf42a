#include "client/text/job_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "client/model/case_changes.hpp"
#include "client/model/curl_history.hpp"
#include "client/session/jobs.hpp"
#include "client/text/findings.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// Steps are cut to milliseconds and less.
std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g s", seconds);
  return text;
}

std::string lower_words(std::string text) {
  for (char& c : text)
    c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Time, step and place of a failure, on a line of its own; empty for one of no particular time.
std::string where_and_when(const v1::Failure& failure) {
  const std::string place = place_text(failure.place_m());
  const bool timed = failure.kind() == v1::Failure::SOLVE_FAILED || failure.time_step_s() > 0.0 ||
                     failure.time_s() != 0.0;
  std::string text;
  if (timed) text += "\nat " + fixed(failure.time_s(), 3) + " s";
  if (failure.time_step_s() > 0.0) text += " with a step of " + seconds_text(failure.time_step_s());
  if (!place.empty()) text += (timed ? ", " : "\nat ") + place;
  return text;
}

/// The end of the residual history.
std::string residuals_text(const v1::Failure& failure) {
  constexpr int shown = 8;
  const int count = failure.residual_history_size();
  std::string text = count > 0 ? "; last residuals:" : "";
  char number[24];
  for (int i = std::max(0, count - shown); i < count; ++i) {
    std::snprintf(number, sizeof number, " %.2e", failure.residual_history(i));
    text += number;
  }
  return text;
}

std::string row(const std::string& name, const std::string& value) {
  return name + std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') + value + "\n";
}

std::string job_cell(const v1::Job& job) {
  return job.id();
}
std::string done_cell(const v1::Job& job) {
  return job.has_last_step() ? fixed(100.0 * job.last_step().progress(), 0) + " %" : "-";
}

std::string labels_cell(const v1::Job& job) {
  std::string text;
  for (const std::string& label : job.labels()) text += (text.empty() ? "" : ",") + label;
  return text;
}

std::string findings_cell(const v1::Job& job) {
  return findings_count(job.findings());
}

std::string left_cell(const v1::Job& job) {
  return job.has_ends_in_s() ? duration_text(job.ends_in_s()) : "";
}
std::string created_cell(const v1::Job& job) {
  return time_text(job.create_time());
}
std::string changes_cell(const v1::Job& job) {
  return changes_text(job.changes());
}
std::string owner_cell(const v1::Job& job) {
  return job.owner();
}
std::string study_cell(const v1::Job& job) {
  return job.study();
}
std::string title_cell(const v1::Job& job) {
  return job.title();
}

struct Column {
  const char* name;
  const char* heading;
  std::string (*cell)(const v1::Job&);
  bool usual;   ///< shown where no columns are asked for
  bool if_any;  ///< then only if a job has something in it
};
constexpr std::array columns{
    Column{"job", "JOB", job_cell, true, false},
    Column{"state", "STATE", full_state_text, true, false},
    Column{"done", ">DONE", done_cell, true, false},
    Column{"curl", ">CURL mm", largest_curl_text, true, false},
    Column{"findings", "FINDINGS", findings_cell, true, true},
    Column{"left", ">LEFT", left_cell, true, true},
    Column{"created", "CREATED", created_cell, true, false},
    Column{"labels", "LABELS", labels_cell, true, true},
    Column{"changes", "CHANGES", changes_cell, false, false},
    Column{"owner", "OWNER", owner_cell, false, false},
    Column{"study", "STUDY", study_cell, false, false},
    Column{"title", "TITLE", title_cell, true, false},
};

std::vector<std::string> usual_columns(const std::vector<v1::Job>& jobs) {
  std::vector<std::string> names;
  for (const Column& column : columns) {
    const auto says_something = [&](const v1::Job& job) { return !column.cell(job).empty(); };
    if (column.usual && (!column.if_any || std::ranges::any_of(jobs, says_something)))
      names.emplace_back(column.name);
  }
  return names;
}

const Column& column_of(const std::string& name) {
  return *std::ranges::find(columns, name, [](const Column& c) { return std::string(c.name); });
}

}  // namespace

std::string largest_curl_text(const v1::Job& job) {
  double largest = NAN;
  for (const v1::MonitorValue& monitor : job.last_step().monitors())
    if (!(std::abs(curl_of(monitor)) <= std::abs(largest))) largest = curl_of(monitor);
  return std::isfinite(largest) ? fixed(1e3 * largest, 2) : "-";
}

std::string state_text(v1::JobState state) {
  return lower_words(v1::JobState_Name(state));
}

std::string time_text(const google::protobuf::Timestamp& time) {
  if (time.seconds() == 0) return "-";
  const std::time_t seconds = time.seconds();
  std::tm local{};
  localtime_r(&seconds, &local);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &local);
  return text;
}

std::string event_line(const v1::JobEvent& event) {
  if (event.has_state_change()) {
    const auto& change = event.state_change();
    return state_text(change.state()) + (change.cause().empty() ? "" : ": " + change.cause());
  }
  if (event.has_message())
    return (event.message().level() == v1::JobEvent::Message::WARNING ? "warning: " : "") +
           event.message().text();
  if (event.has_resumed())
    return event.resumed().step() == 0
               ? "started over"
               : "resumed after step " + std::to_string(event.resumed().step()) + " at " +
                     fixed(event.resumed().time_s(), 2) + " s";
  if (event.has_validity_lost()) return "warning: " + validity_text(event.validity_lost());
  if (event.has_finding()) return finding_line(event.finding());
  if (event.has_run_ended()) return "the run has ended";
  return "event " + std::to_string(event.sequence());
}

std::string failure_kind_text(v1::Failure::Kind kind) {
  switch (kind) {
    case v1::Failure::KIND_UNSPECIFIED:
      return "failed";
    case v1::Failure::LIQUID_PRESSURE_LOST:
      return "pressure of the liquid lost";
    case v1::Failure::OTHER_VERSION:
      return "checkpoint of another version of the solver";
    default:
      return lower_words(v1::Failure_Kind_Name(kind));
  }
}

std::string full_state_text(const v1::Job& job) {
  std::string text = state_text(job.state());
  if (job.queue_position() > 0) text += " #" + std::to_string(job.queue_position());
  if (!job.held().empty()) text += ", held";
  if (job.has_validity_loss()) text += std::string(", ") + beyond_validity;
  return text;
}

std::string failure_text(const v1::Failure& failure) {
  std::string text = failure_kind_text(failure.kind()) + ": " + failure.message() +
                     where_and_when(failure) + residuals_text(failure);
  for (const std::string& cause : failure.further_causes()) text += "\nthen: " + cause;
  return text;
}

std::string job_sheet(const v1::Job& job) {
  std::string text =
      row("job", job.id()) + row("title", job.title()) + row("state", state_text(job.state()));
  if (!job.cause().empty()) text += row("cause", job.cause());
  if (job.queue_position() > 0)
    text += row("queue", "position " + std::to_string(job.queue_position()));
  if (!job.held().empty()) text += row("held", job.held());
  if (job.has_starts_in_s()) text += row("starts in", duration_text(job.starts_in_s()));
  if (job.has_ends_in_s()) text += row("ends in", duration_text(job.ends_in_s()));
  text += row("priority", lower_words(v1::Priority_Name(job.priority())));
  text += row("created", time_text(job.create_time())) +
          row("started", time_text(job.start_time())) + row("ended", time_text(job.end_time()));
  text += row("attempts", std::to_string(job.attempts())) + row("request id", job.request_id());
  if (!job.owner().empty()) text += row("owner", job.owner());
  if (!job.study().empty()) text += row("study", job.study());
  for (const std::string& label : job.labels()) text += row("label", label);
  if (job.pinned()) text += row("pinned", "kept when old jobs are deleted");
  if (job.time_limit_s() > 0.0) text += row("time limit", duration_text(job.time_limit_s()));
  if (!job.mail().empty()) text += row("mail", job.mail());
  for (const std::string& before : job.after()) text += row("after", before);
  for (const v1::CaseChange& change : job.changes())
    text += row("changed", change.key() + " = " + change.value());
  text += row("case sha256", job.case_sha256());
  if (job.has_last_step()) {
    const v1::StepReport& step = job.last_step();
    text += row("progress", fixed(100.0 * step.progress(), 1) + " %") +
            row("last step", step_line(step));
    text += row("mesh", std::to_string(step.nodes()) + " nodes, " +
                            std::to_string(step.elements()) + " elements");
    text += row("solver time", duration_text(step.solver_s()));
  }
  for (const v1::Finding& finding : job.findings()) text += row("finding", finding_line(finding));
  if (job.has_validity_loss()) text += row("validity", validity_text(job.validity_loss()));
  if (job.has_failure()) text += row("failure", failure_text(job.failure()));
  for (const v1::Artifact& artifact : job.artifacts())
    text += row("artifact", artifact.name() + "  " + std::to_string(artifact.size_bytes()) +
                                " bytes  sha256 " + artifact.sha256());
  return text;
}

std::vector<std::string> job_columns() {
  std::vector<std::string> names;
  for (const Column& column : columns) names.emplace_back(column.name);
  return names;
}

std::string job_table(const std::vector<v1::Job>& jobs, std::vector<std::string> names) {
  if (names.empty()) names = usual_columns(jobs);
  std::vector<std::string> headings, ids;
  for (const std::string& name : names) headings.emplace_back(column_of(name).heading);
  for (const v1::Job& job : jobs) ids.push_back(job.id());
  const std::size_t length = short_id_length(ids);
  Table table(headings);
  for (const v1::Job& job : jobs) {
    std::vector<std::string> row;
    for (const std::string& name : names) {
      const std::string cell = column_of(name).cell(job);
      row.push_back(name == "job" ? cell.substr(0, length) : cell);
    }
    table.add(std::move(row));
  }
  return table.text();
}

}  // namespace dccast::client::render
