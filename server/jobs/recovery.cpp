#include "server/jobs/recovery.hpp"

#include <set>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/storage_fault.hpp"

namespace dccast::jobs {

namespace {

/// The log knows of an end that the store does not: the daemon died between the two.
void take_over_end(const v1::JobEvent& event, v1::Job& job) {
  if (event.state_change().has_failure()) *job.mutable_failure() = event.state_change().failure();
  *job.mutable_artifacts() = event.state_change().artifacts();
  *job.mutable_end_time() = timestamp(milliseconds(event.time()));
}

/// Whether a worker that was found may go on with its job: it runs for store and log, the log tells
/// which of its reports are there, nobody has cancelled it, and the worker can prove itself.
bool may_go_on(const EventLog& log, const JobRecord& record) {
  return log.last_state() == v1::RUNNING && record.job.state() == v1::RUNNING &&
         log.attempt_reports() && record.requested_action != RequestedAction::cancel &&
         !record.worker_token_sha256.empty();
}

/// Brings one job into the state in which the next daemon finds it.
void recover_job(EventLogs& logs, Ledger& ledger, JobRecord& record, bool has_worker) {
  const auto log = logs.open(record.job.id());
  if (has_worker && may_go_on(*log, record))
    return spdlog::info("job {}: its worker ({}) was found again", record.job.id(),
                        record.worker_handle);
  record.worker_token_sha256.clear();
  if (const auto end = log->terminal_event()) {
    take_over_end(*end, record.job);
    return ledger.transition(
        record, end->state_change().state(),
        "ended just before the last daemon did: " + end->state_change().cause());
  }
  if (record.requested_action == RequestedAction::cancel)
    return ledger.transition(record, v1::CANCELLED, "cancelled before dccastd was restarted");
  if (std::exchange(record.requested_action, RequestedAction::none) == RequestedAction::pause)
    return ledger.transition(record, v1::PAUSED, "paused before dccastd was restarted");
  // A transition is in the log before it is in the store.
  const v1::JobState state = log->last_state().value_or(record.job.state());
  if (state == v1::RUNNING)
    return ledger.transition(record, v1::QUEUED,
                             "dccastd was restarted; goes on from its last checkpoint");
  if (state != record.job.state())
    ledger.transition(record, state, "as its event log says; dccastd was restarted");
}

/// With a full disk the job waits as it is; with damaged files of its own it has failed.
void recover_damaged(Ledger& ledger, JobRecord& record, const std::exception& error) {
  if (daemon_lacks(error)) {
    if (record.job.state() == v1::RUNNING)
      ledger.settle(record, v1::QUEUED, "dccastd was restarted; goes on from its last checkpoint");
    return;
  }
  add_failure(record.job, v1::Failure::STORAGE, error.what());
  ledger.settle(record, v1::FAILED, error.what());
}

}  // namespace

RecoveredJobs recover_jobs(const std::filesystem::path& jobs_directory, JobStore& store,
                           EventLogs& logs, Ledger& ledger, Executor& executor) {
  std::vector<JobRecord> unfinished = store.unfinished();
  // All workers first: none that is to go may still write when anything of theirs is looked at.
  std::set<std::string> found;
  for (JobRecord& record : unfinished) {
    const std::string& id = record.job.id();
    const WorkerLaunch launch{
        .job_id = id, .attempt = record.job.attempts(), .folder = jobs_directory / id};
    if (executor.adopt(record.worker_handle, launch) == Adoption::found)
      found.insert(id);
    else
      record.worker_handle.clear();
  }
  RecoveredJobs recovered;
  for (JobRecord& record : unfinished) {
    const bool has_worker = found.contains(record.job.id());
    try {
      recover_job(logs, ledger, record, has_worker);
    } catch (const StoreError&) {
      throw;
    } catch (const std::exception& error) {
      recover_damaged(ledger, record, error);
    }
    if (has_worker)
      recovered.with_worker.push_back(std::move(record));
    else if (record.job.state() == v1::QUEUED)
      recovered.waiting.push_back(record.job);
  }
  return recovered;
}

}  // namespace dccast::jobs
