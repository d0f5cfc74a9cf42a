#include "server/jobs/events.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace dccast::jobs {

google::protobuf::Timestamp now() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since_1970);
  google::protobuf::Timestamp time;
  time.set_seconds(seconds.count());
  time.set_nanos(static_cast<int>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970 - seconds).count()));
  return time;
}

std::int64_t milliseconds(const google::protobuf::Timestamp& time) {
  return time.seconds() * 1000 + time.nanos() / 1000000;
}

google::protobuf::Timestamp timestamp(std::int64_t milliseconds) {
  google::protobuf::Timestamp time;
  time.set_seconds(milliseconds / 1000);
  time.set_nanos(static_cast<int>(milliseconds % 1000 * 1000000));
  return time;
}

bool is_terminal(v1::JobState state) {
  return state == v1::SUCCEEDED || state == v1::FAILED || state == v1::CANCELLED;
}

void add_failure(v1::Job& job, v1::Failure::Kind kind, const std::string& message) {
  if (job.has_failure()) {
    job.mutable_failure()->add_further_causes(message);
    return;
  }
  job.mutable_failure()->set_kind(kind);
  job.mutable_failure()->set_message(message);
}

void keep_finding(google::protobuf::RepeatedPtrField<v1::Finding>& findings,
                  const v1::Finding& finding) {
  const auto known = std::ranges::find(findings, finding.code(), &v1::Finding::code);
  if (known == findings.end())
    *findings.Add() = finding;
  else
    *known = finding;
}

v1::JobEvent message_event(std::string text, v1::JobEvent::Message::Level level) {
  v1::JobEvent event;
  event.mutable_message()->set_level(level);
  event.mutable_message()->set_text(std::move(text));
  return event;
}

v1::JobEvent state_event(const v1::Job& job, const std::string& cause) {
  v1::JobEvent event;
  auto* change = event.mutable_state_change();
  change->set_state(job.state());
  change->set_cause(cause);
  change->set_terminal(is_terminal(job.state()));
  change->set_attempt(job.attempts());
  if (!change->terminal()) return event;
  if (job.has_failure()) *change->mutable_failure() = job.failure();
  *change->mutable_artifacts() = job.artifacts();
  return event;
}

v1::JobEvent state_event(const JobRecord& record, const std::string& cause) {
  v1::JobEvent event = state_event(record.job, cause);
  auto* change = event.mutable_state_change();
  if (record.losses > 0) {
    change->mutable_losses()->set_times(record.losses);
    change->mutable_losses()->set_last_step(record.lost_step);
    change->mutable_losses()->set_first_cause(record.first_loss);
  }
  change->set_solver(record.solver);
  return event;
}

}  // namespace dccast::jobs
