#include "server/state/adoption.hpp"

#include <algorithm>

#include "server/jobs/event_log.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

void take_state(const v1::JobEvent& event, v1::Job& job) {
  const auto& change = event.state_change();
  job.set_state(change.state());
  if (change.state() == v1::RUNNING) {
    job.set_attempts(job.attempts() + 1);
    if (!job.has_start_time()) *job.mutable_start_time() = event.time();
  }
  if (!change.terminal()) return;
  *job.mutable_end_time() = event.time();
  if (change.has_failure()) *job.mutable_failure() = change.failure();
  *job.mutable_artifacts() = change.artifacts();
}

/// A log that is gone can be begun again only while nothing else says what became of the job.
void require_log(const fs::path& folder) {
  if (fs::exists(folder / "events.log")) return;
  if (fs::exists(folder / "results.h5"))
    throw std::runtime_error("its events.log is lost, and it has results of an unknown attempt");
}

/// As the scheduler counts a submission.
std::int64_t bytes_of(const fs::path& folder, const jobs::JobDescription& description) {
  auto bytes = description.submitted_case.size() + description.complete_case.size();
  if (fs::exists(folder / jobs::attachments_folder))
    for (const auto& file : fs::directory_iterator(folder / jobs::attachments_folder))
      bytes += file.file_size();
  return static_cast<std::int64_t>(bytes);
}

}  // namespace

void bring_up_to_log(jobs::JobRecord& record, const fs::path& path) {
  const jobs::EventLog log(path);
  v1::Job& job = record.job;
  const int attempts = job.attempts();
  job.set_attempts(0);
  jobs::EventLog::Cursor cursor;
  while (const auto event = log.read(cursor)) {
    if (event->has_state_change()) take_state(*event, job);
    if (event->has_validity_lost()) *job.mutable_validity_loss() = event->validity_lost();
  }
  job.set_attempts(
      std::max(job.attempts(), attempts));  // a start may be among events that are lost
  log.tell(job);
}

void adopt(jobs::JobStore& store, const fs::path& folder) {
  const jobs::JobDescription description = jobs::read_job_description(folder);
  if (description.job.id() != folder.filename())
    throw std::runtime_error("it describes another job, " + description.job.id());
  require_log(folder);
  jobs::JobRecord record;
  record.job = description.job;
  record.job.set_state(v1::QUEUED);
  record.bytes = bytes_of(folder, description);
  bring_up_to_log(record, folder / "events.log");
  if (const auto there =
          store.insert(record, description.submitted_case, description.complete_case))
    throw std::runtime_error("its request_id \"" + record.job.request_id() + "\" belongs to job " +
                             there->job.id());
  store.update(record, jobs::Durability::full);
  jobs::mark_accepted(folder);
  if (jobs::is_terminal(record.job.state())) return;
  jobs::EventLog log(folder / "events.log");
  v1::JobEvent event = jobs::message_event("the job was taken back into the store from its folder",
                                           v1::JobEvent::Message::WARNING);
  log.append(event);
}

std::string contradiction(jobs::JobStore& store, const jobs::JobRecord& record,
                          const jobs::JobDescription& description) {
  const v1::Job& row = record.job;
  const v1::Job& said = description.job;
  if (row.id() != said.id()) return "id";
  if (row.title() != said.title()) return "title";
  if (row.request_id() != said.request_id()) return "request_id";
  if (row.study() != said.study()) return "study";
  if (row.owner() != said.owner()) return "owner";
  if (row.priority() != said.priority()) return "priority";
  if (row.case_sha256() != said.case_sha256()) return "case_sha256";
  if (jobs::milliseconds(row.create_time()) != jobs::milliseconds(said.create_time()))
    return "create_time";
  if (store.complete_case(row.id()) != description.complete_case) return "complete case";
  if (store.submitted_case(row.id()) != description.submitted_case) return "submitted case";
  return {};
}

}  // namespace dccast::state
