#include "client/render/job_text.hpp"

#include <algorithm>
#include <cctype>
#include <ctime>

#include "client/render/progress.hpp"
#include "client/render/table.hpp"

namespace dccast::client::render {
namespace {

std::string lower_words(std::string text) {
  for (char& c : text)
    c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string row(const std::string& name, const std::string& value) {
  return name + std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') + value + "\n";
}

}  // namespace

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
    return "resumed after step " + std::to_string(event.resumed().step()) + " at " +
           fixed(event.resumed().time_s(), 2) + " s";
  return "event " + std::to_string(event.sequence());
}

std::string failure_text(const v1::Failure& failure) {
  std::string text = lower_words(v1::Failure_Kind_Name(failure.kind())) + ": " + failure.message();
  if (failure.kind() != v1::Failure::SOLVE_FAILED) return text;
  text += "\nat " + fixed(failure.time_s(), 3) + " s with a step of " +
          fixed(1e3 * failure.time_step_s(), 3) + " ms";
  if (failure.residual_history_size() == 0) return text;
  text += "; last residuals:";
  char number[24];
  for (int i = std::max(0, failure.residual_history_size() - 8);
       i < failure.residual_history_size(); ++i) {
    std::snprintf(number, sizeof number, " %.2e", failure.residual_history(i));
    text += number;
  }
  return text;
}

std::string job_sheet(const v1::Job& job) {
  std::string text =
      row("job", job.id()) + row("title", job.title()) + row("state", state_text(job.state()));
  if (job.queue_position() > 0)
    text += row("queue", "position " + std::to_string(job.queue_position()));
  text += row("priority", lower_words(v1::Priority_Name(job.priority())));
  text += row("created", time_text(job.create_time())) +
          row("started", time_text(job.start_time())) + row("ended", time_text(job.end_time()));
  text += row("attempts", std::to_string(job.attempts())) + row("request id", job.request_id());
  if (!job.study().empty()) text += row("study", job.study());
  text += row("case sha256", job.case_sha256());
  if (job.has_last_step()) {
    const v1::StepReport& step = job.last_step();
    text += row("progress", fixed(100.0 * step.progress(), 1) + " %") +
            row("last step", step_line(step));
    text += row("mesh", std::to_string(step.nodes()) + " nodes, " +
                            std::to_string(step.elements()) + " elements");
    text += row("solver time", duration_text(step.solver_s()));
  }
  if (job.has_failure()) text += row("failure", failure_text(job.failure()));
  for (const v1::Artifact& artifact : job.artifacts())
    text += row("artifact", artifact.name() + "  " + std::to_string(artifact.size_bytes()) +
                                " bytes  sha256 " + artifact.sha256());
  return text;
}

}  // namespace dccast::client::render
