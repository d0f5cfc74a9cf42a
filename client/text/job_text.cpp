#include "client/text/job_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>

#include <fmt/core.h>

#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/text/findings.hpp"
#include "client/text/progress.hpp"
#include "client/text/study_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client {
namespace {

std::string lower_words(std::string text) {
  for (char& c : text)
    c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Time, step and place of a failure, on a line of its own; empty without a time.
std::string where_and_when(const v1::Finding& failure) {
  const std::string place = place_text(failure.place_m());
  const bool timed = failure.kind() == v1::Finding::SOLVE_FAILED || failure.time_step_s() > 0.0 ||
                     failure.time_s() != 0.0;
  std::string text;
  if (timed) text += "\nat " + fixed(failure.time_s(), 3) + " s";
  if (failure.time_step_s() > 0.0)
    text += " with a step of " + fmt::format("{:.3g} s", failure.time_step_s());
  if (!place.empty()) text += (timed ? ", " : "\nat ") + place;
  return text;
}

/// The last entries of the residual history.
std::string residuals_text(const v1::Finding& failure) {
  constexpr int shown = 8;
  const int count = failure.residual_history_size();
  std::string text = count > 0 ? "; last residuals:" : "";
  for (int i = std::max(0, count - shown); i < count; ++i)
    text += fmt::format(" {:.2e}", failure.residual_history(i));
  return text;
}

/// Enough of an id to name a job in a line.
std::string short_id(const std::string& id) {
  constexpr std::size_t length = 8;
  return id.substr(0, length);
}

/// When a column is printed; `if_any`: if some job has something in it.
enum class Visibility { always, if_any, on_request };

using Row = const v1::Job&;
using StudyRow = const v1::Study&;

struct ListColumn {
  const char* name;
  const char* heading;
  std::string (*cell)(Row);
  Visibility visibility = Visibility::always;
  std::string (*study_cell)(StudyRow) = [](StudyRow) { return std::string(); };
};

std::string done_cell(Row job) {
  return job.has_last_step() ? fixed(100.0 * job.last_step().progress(), 0) + " %" : "-";
}

std::string left_cell(Row job) {
  return job.has_ends_in_s() ? duration_text(job.ends_in_s()) : "";
}

std::string priority_cell(Row job) {
  const bool is_usual = job.priority() == v1::NORMAL || job.priority() == v1::PRIORITY_UNSPECIFIED;
  return is_usual ? "" : lower_words(v1::Priority_Name(job.priority()));
}

std::string study_title(StudyRow study) {
  const std::string title = study.title().empty() ? plan_text(study) : study.title();
  return fmt::format("{} (study, {})", title, runs_text(study));
}

const std::array list_columns{
    ListColumn{"job", "JOB", [](Row job) { return job.id(); }, Visibility::always,
               [](StudyRow study) { return study.id(); }},
    ListColumn{"state", "STATE", full_state_text, Visibility::always,
               [](StudyRow study) { return state_text(study); }},
    ListColumn{"done", ">DONE", done_cell, Visibility::always,
               [](StudyRow study) { return fixed(100.0 * study.progress(), 0) + " %"; }},
    ListColumn{"curl", ">CURL mm", judged_curl_text, Visibility::always,
               [](StudyRow) { return std::string("-"); }},
    ListColumn{"findings", "FINDINGS", [](Row job) { return findings_count(job.findings()); },
               Visibility::if_any},
    ListColumn{"left", ">LEFT", left_cell, Visibility::if_any},
    ListColumn{"created", "CREATED", [](Row job) { return time_text(job.create_time()); },
               Visibility::always, [](StudyRow study) { return time_text(study.create_time()); }},
    ListColumn{"labels", "LABELS", [](Row job) { return joined(job.labels(), ","); },
               Visibility::if_any, [](StudyRow study) { return joined(study.labels(), ","); }},
    ListColumn{"priority", "PRIORITY", priority_cell, Visibility::if_any},
    ListColumn{"started", "STARTED", [](Row job) { return time_text(job.start_time()); },
               Visibility::on_request},
    ListColumn{"took", ">TOOK",
               [](Row job) { return job.run_s() > 0.0 ? duration_text(job.run_s()) : "-"; },
               Visibility::on_request},
    ListColumn{"changes", "CHANGES", [](Row job) { return changes_text(job.changes()); },
               Visibility::on_request},
    ListColumn{"owner", "OWNER", [](Row job) { return job.owner(); }, Visibility::on_request,
               [](StudyRow study) { return study.owner(); }},
    ListColumn{"study", "STUDY", [](Row job) { return job.study(); }, Visibility::on_request,
               [](StudyRow study) { return study.id(); }},
    ListColumn{"title", "TITLE", [](Row job) { return job.title(); }, Visibility::always,
               study_title},
};

std::string cell_of(const ListColumn& column, const ListLine& line) {
  return line.study ? column.study_cell(*line.study) : column.cell(line.job);
}

std::vector<std::string> usual_columns(const std::vector<ListLine>& lines) {
  std::vector<std::string> names;
  for (const ListColumn& column : list_columns) {
    const auto says_something = [&](const ListLine& line) {
      return !cell_of(column, line).empty();
    };
    if (column.visibility == Visibility::always ||
        (column.visibility == Visibility::if_any && std::ranges::any_of(lines, says_something)))
      names.emplace_back(column.name);
  }
  return names;
}

const ListColumn& column_of(const std::string& name) {
  return *std::ranges::find(list_columns, name,
                            [](const ListColumn& c) { return std::string(c.name); });
}

}  // namespace

const v1::MonitorValue* sound_curl(const v1::Job& job) {
  // A run that failed has a last step, but no curl as of a good one.
  if (job.state() == v1::FAILED || job.has_validity_loss()) return nullptr;
  return figures::judged_curl(job.last_step());
}

std::string judged_curl_text(const v1::Job& job) {
  const v1::MonitorValue* const judged = sound_curl(job);
  return judged == nullptr ? "-" : mm(judged->curl_m(), 2);
}

std::string state_text(v1::JobState state) {
  return lower_words(v1::JobState_Name(state));
}

std::string start_text(double starts_in_s) {
  return starts_in_s < 1.0 ? "a moment" : duration_text(starts_in_s);
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
  if (event.has_resumed() && event.resumed().step() == 0) return "started over";
  if (event.has_resumed())
    return fmt::format("resumed after step {} at {} s", event.resumed().step(),
                       fixed(event.resumed().time_s(), 2));
  if (event.has_validity_lost()) return "warning: " + validity_text(event.validity_lost());
  if (event.has_finding()) return finding_line(event.finding());
  if (event.has_run_ended()) return "the run has ended";
  return "event " + std::to_string(event.sequence());
}

std::string failure_kind_text(v1::Finding::Kind kind) {
  switch (kind) {
    case v1::Finding::KIND_UNSPECIFIED:
      return "failed";
    case v1::Finding::OTHER_VERSION:
      return "checkpoint of another version of the solver";
    default:
      return lower_words(v1::Finding_Kind_Name(kind));
  }
}

bool waits_for_others(const v1::Job& job) {
  return job.state() == v1::QUEUED && job.queue_position() == 0 && job.after_size() > 0;
}

bool waits_for_its_time(const v1::Job& job) {
  return job.state() == v1::QUEUED && job.queue_position() == 0 &&
         job.begin_time().seconds() > std::time(nullptr);
}

std::string full_state_text(const v1::Job& job) {
  std::string text = state_text(job.state());
  if (job.queue_position() > 0) text += " #" + std::to_string(job.queue_position());
  const bool waits = waits_for_others(job) || waits_for_its_time(job);
  if (waits_for_others(job)) text += ", after " + joined(job.after(), ", ", short_id);
  if (waits_for_its_time(job)) text += ", from " + time_text(job.begin_time());
  if (!waits && !job.held().empty()) text += ", held";
  if (job.has_validity_loss()) text += std::string(", ") + beyond_validity;
  return text;
}

std::string failure_text(const v1::Finding& failure) {
  std::string text = failure_kind_text(failure.kind()) + ": " + failure.message() +
                     where_and_when(failure) + residuals_text(failure);
  for (const v1::Finding& further : failure.further()) {
    const bool has_kind = further.kind() != v1::Finding::KIND_UNSPECIFIED;
    text +=
        "\nthen: " + (has_kind ? failure_kind_text(further.kind()) + ": " : "") + further.message();
  }
  return text;
}

std::string job_sheet(const v1::Job& job) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    text += sheet_line(name, value);
  };
  const auto add_any = [&](const char* name, const std::string& value) {
    if (!value.empty()) add(name, value);
  };

  // Its state, and where it stands in the queue.
  add("job", job.id());
  add("title", job.title());
  add("state", state_text(job.state()));
  add_any("cause", job.cause());
  if (job.queue_position() > 0) add("queue", "position " + std::to_string(job.queue_position()));
  add_any("held", job.held());
  if (job.has_starts_in_s()) add("starts in", start_text(job.starts_in_s()));
  if (job.has_ends_in_s()) add("ends in", duration_text(job.ends_in_s()));
  add("priority", lower_words(v1::Priority_Name(job.priority())));

  add("created", time_text(job.create_time()));
  add("started", time_text(job.start_time()));
  add("ended", time_text(job.end_time()));
  add("attempts", std::to_string(job.attempts()));

  // Whose it is, and what it belongs to.
  add("request id", job.request_id());
  add_any("owner", job.owner());
  add_any("study", job.study());
  for (const std::string& label : job.labels()) add("label", label);
  if (job.pinned()) add("pinned", "kept when old jobs are deleted");
  if (job.time_limit_s() > 0.0) add("time limit", duration_text(job.time_limit_s()));
  add_any("mail", job.mail());
  const char* end = job.after_end() == v1::AWAITED_FAILURE   ? "failure of "
                    : job.after_end() == v1::AWAITED_ANY_END ? "end of "
                                                             : "";
  for (const std::string& before : job.after()) add("after", end + before);
  if (job.has_begin_time()) add("begins", time_text(job.begin_time()));

  for (const v1::CaseChange& change : job.changes())
    add("changed", change.key() + " = " + change.value());
  add("case sha256", job.case_sha256());

  // How far it has come, and what came of it.
  if (job.has_last_step()) {
    const v1::StepReport& step = job.last_step();
    add("progress", fixed(100.0 * step.progress(), 1) + " %");
    add("last step", step_line(step));
    add("mesh", fmt::format("{} nodes, {} elements", step.nodes(), step.elements()));
    add("solver time", duration_text(step.solver_s()));
  }

  for (const v1::Finding& finding : job.findings()) add("finding", finding_line(finding));
  if (job.has_validity_loss()) add("validity", validity_text(job.validity_loss()));
  if (job.has_failure()) add("failure", failure_text(job.failure()));
  for (const v1::Artifact& artifact : job.artifacts())
    add("artifact", fmt::format("{}  {} bytes  sha256 {}", artifact.name(), artifact.size_bytes(),
                                artifact.sha256()));
  return text;
}

std::vector<std::string> job_columns() {
  std::vector<std::string> names;
  for (const ListColumn& column : list_columns) names.emplace_back(column.name);
  return names;
}

std::string job_table(const std::vector<ListLine>& lines, std::vector<std::string> names,
                      const Terminal& terminal) {
  if (names.empty()) names = usual_columns(lines);
  std::vector<std::string> headings, ids;
  for (const std::string& name : names) headings.emplace_back(column_of(name).heading);
  for (const ListLine& line : lines) ids.push_back(line.study ? line.study->id() : line.job.id());
  const std::size_t length = short_id_length(ids);

  Table table(headings);
  for (const ListLine& line : lines) {
    std::vector<std::string> row;
    for (const std::string& name : names) {
      const std::string cell = cell_of(column_of(name), line);
      row.push_back(name == "job" ? (line.below_study ? "  " : "") + cell.substr(0, length) : cell);
    }
    table.add(std::move(row));
  }
  if (!terminal.interactive) return table.text();

  // A line that is too long for the terminal would be two, and no table any more.
  std::string text;
  std::istringstream whole(table.text());
  for (std::string line; std::getline(whole, line);) text += cut_to(line, terminal.columns) + "\n";
  return text;
}

}  // namespace dccast::client
