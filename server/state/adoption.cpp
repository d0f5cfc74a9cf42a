#include "server/state/adoption.hpp"

#include <algorithm>

#include "server/jobs/event_log.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// A log that is gone can be begun again only while nothing else shows what became of the job.
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
  const jobs::EventLogContent content = log.content();
  v1::Job& job = record.job;
  job.set_attempts(std::max(job.attempts(), content.attempts));
  if (content.started && !job.has_start_time()) *job.mutable_start_time() = *content.started;
  log.complete(job);
  if (!content.last_state) return;
  const v1::JobEvent::StateChange& change = *content.last_state;
  job.set_state(change.state());
  record.losses = change.losses().times();
  record.lost_step = change.has_losses() ? change.losses().last_step() : -1;
  record.first_loss = change.losses().first_cause();
  record.solver = change.solver();
  if (!change.terminal()) return;
  if (content.terminal) *job.mutable_end_time() = content.terminal->time();
  if (change.has_failure()) *job.mutable_failure() = change.failure();
  *job.mutable_artifacts() = change.artifacts();
}

void adopt(jobs::JobStore& store, const fs::path& folder) {
  const jobs::JobDescription description = jobs::read_job_description(folder);
  if (description.job.id() != folder.filename())
    throw std::runtime_error("it describes another job, " + description.job.id());
  require_log(folder);
  jobs::JobRecord record;
  record.job = description.job;
  record.job.set_state(v1::QUEUED);
  record.answer_key = description.answer_key;
  record.bytes = bytes_of(folder, description);
  bring_up_to_log(record, folder / "events.log");
  if (const auto request = jobs::read_request(folder)) {
    record.requested_action = request->action;
    record.request_reason = request->reason;
  }
  if (const auto there =
          store.insert(record, description.submitted_case, description.complete_case))
    throw std::runtime_error("its request_id \"" + record.job.request_id() + "\" belongs to job " +
                             there->job.id());
  store.update(record, jobs::Durability::full);
  jobs::mark_accepted(folder);
}

std::string contradiction(jobs::JobStore& store, const jobs::JobRecord& record,
                          const jobs::JobDescription& description) {
  const v1::Job& row = record.job;
  const v1::Job& described = description.job;
  if (row.id() != described.id()) return "id";
  if (row.title() != described.title()) return "title";
  if (row.request_id() != described.request_id()) return "request_id";
  if (row.study() != described.study()) return "study";
  if (row.owner() != described.owner()) return "owner";
  if (row.priority() != described.priority()) return "priority";
  if (row.case_sha256() != described.case_sha256()) return "case_sha256";
  if (jobs::milliseconds(row.create_time()) != jobs::milliseconds(described.create_time()))
    return "create_time";
  if (store.complete_case(row.id()) != description.complete_case) return "complete case";
  if (store.submitted_case(row.id()) != description.submitted_case) return "submitted case";
  return {};
}

}  // namespace dccast::state
