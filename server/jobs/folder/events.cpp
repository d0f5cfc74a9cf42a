#include "server/jobs/folder/events.hpp"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "proto/values/digests.hpp"

namespace dccast::jobs {

using google::protobuf::util::TimeUtil;

google::protobuf::Timestamp now() {
  using std::chrono::nanoseconds;
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return TimeUtil::NanosecondsToTimestamp(nanoseconds(since_1970).count());
}

std::int64_t milliseconds(const google::protobuf::Timestamp& time) {
  return TimeUtil::TimestampToMilliseconds(time);
}

google::protobuf::Timestamp timestamp(std::int64_t milliseconds) {
  return TimeUtil::MillisecondsToTimestamp(milliseconds);
}

bool is_terminal(v1::JobState state) {
  return state == v1::SUCCEEDED || state == v1::FAILED || state == v1::CANCELLED;
}

void add_failure(v1::Job& job, v1::Finding::Kind kind, const std::string& message) {
  v1::Finding& failure =
      job.has_failure() ? *job.mutable_failure()->add_further() : *job.mutable_failure();
  failure.set_kind(kind);
  failure.set_message(message);
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

JobRecord make_record(const NewJob& new_job, const Attachments& attachments) {
  JobRecord record;
  v1::Job& job = record.job;

  job.set_id(values::random_uuid());
  job.set_title(new_job.title);
  job.set_state(v1::QUEUED);
  job.set_priority(new_job.priority == v1::PRIORITY_UNSPECIFIED ? v1::NORMAL : new_job.priority);

  job.set_request_id(new_job.request_id);
  job.set_study(new_job.study);
  job.set_owner(new_job.owner);
  job.set_case_sha256(new_job.case_sha256);

  job.mutable_labels()->Assign(new_job.labels.begin(), new_job.labels.end());
  job.mutable_changes()->Assign(new_job.changes.begin(), new_job.changes.end());
  job.mutable_after()->Assign(new_job.after.begin(), new_job.after.end());

  job.set_time_limit_s(new_job.time_limit_s);
  job.set_mail(new_job.mail);
  job.set_quality(new_job.quality);
  job.set_estimated_s(new_job.estimated_s);

  // In the precision of the store, so that a record read back is equal.
  *job.mutable_create_time() = timestamp(milliseconds(now()));  // as exactly as the store keeps it
  record.bytes = static_cast<std::int64_t>(new_job.submitted_case.size() +
                                           new_job.complete_case.size() + new_job.case_file.size());
  for (const AttachedFile& attachment : attachments) record.bytes += attachment.bytes;

  record.answer_key = new_job.answer_key;

  return record;
}

}  // namespace dccast::jobs
