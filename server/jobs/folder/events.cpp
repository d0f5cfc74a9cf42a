#include "server/jobs/folder/events.hpp"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <utility>

#include "proto/values/digests.hpp"

namespace dccast::jobs {

using google::protobuf::util::TimeUtil;

namespace {

/// The time of a submission [ms since 1970]. Jobs start in the order of these times, so no two are
/// alike: one that comes in the millisecond of another gets the next. A clock that was set back by
/// more than a second counts anew.
std::int64_t submission_time() {
  constexpr std::int64_t longest_lead = 1000;
  static std::atomic<std::int64_t> last = 0;

  std::int64_t before = last, time = 0;
  do {
    time = milliseconds(now());
    if (time <= before && before - time < longest_lead) time = before + 1;
  } while (!last.compare_exchange_weak(before, time));
  return time;
}

}  // namespace

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

bool ends_as_awaited(v1::JobState state, v1::AwaitedEnd end) {
  if (end == v1::AWAITED_ANY_END) return true;
  return state == (end == v1::AWAITED_FAILURE ? v1::FAILED : v1::SUCCEEDED);
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

v1::JobEvent state_event(const JobRecord& record, const std::string& cause) {
  const v1::Job& job = record.job;
  v1::JobEvent event;
  auto* change = event.mutable_state_change();
  change->set_state(job.state());
  change->set_cause(cause);
  change->set_terminal(is_terminal(job.state()));
  change->set_attempt(job.attempts());
  if (record.losses.times() > 0) *change->mutable_losses() = record.losses;
  change->set_solver(record.solver);

  // The times of the job are those of its first start and of its end.
  if (job.state() == v1::RUNNING && job.attempts() == 1 && job.has_start_time())
    *event.mutable_time() = job.start_time();
  if (!change->terminal()) return event;

  if (job.has_end_time()) *event.mutable_time() = job.end_time();
  if (job.has_failure()) *change->mutable_failure() = job.failure();
  *change->mutable_artifacts() = job.artifacts();
  return event;
}

JobRecord make_record(const NewJob& new_job, const Attachments& attachments) {
  const JobDescription& description = new_job.description;
  JobRecord record;
  record.job = description.job;
  record.job.set_id(values::random_uuid());
  record.job.set_state(v1::QUEUED);
  if (record.job.priority() == v1::PRIORITY_UNSPECIFIED) record.job.set_priority(v1::NORMAL);
  *record.job.mutable_create_time() = timestamp(submission_time());

  record.bytes =
      static_cast<std::int64_t>(description.submitted_case.size() +
                                description.complete_case.size() + new_job.case_file.size());
  for (const AttachedFile& attachment : attachments) record.bytes += attachment.bytes;
  record.answer_key = description.answer_key;
  return record;
}

}  // namespace dccast::jobs
