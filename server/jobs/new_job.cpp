#include "server/jobs/new_job.hpp"

#include "proto/values/digests.hpp"
#include "server/jobs/events.hpp"

namespace dccast::jobs {

namespace {

v1::Job new_job_message(const NewJob& new_job) {
  v1::Job job;
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
  *job.mutable_create_time() = timestamp(milliseconds(now()));  // as exactly as the store keeps it
  return job;
}

std::int64_t size_of(const NewJob& new_job, const Attachments& attachments) {
  auto bytes =
      static_cast<std::int64_t>(new_job.submitted_case.size() + new_job.complete_case.size());
  for (const v1::Attachment& attachment : attachments)
    bytes += static_cast<std::int64_t>(attachment.content().size());
  return bytes;
}

}  // namespace

JobRecord record_of_new(const NewJob& new_job, const Attachments& attachments) {
  JobRecord record;
  record.job = new_job_message(new_job);
  record.bytes = size_of(new_job, attachments);
  record.answer_key = new_job.answer_key;
  return record;
}

}  // namespace dccast::jobs
