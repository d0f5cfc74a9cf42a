// Runs that were computed outside of the queue and become jobs.

#include <system_error>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

namespace {

/// What the run leaves in the job, but for its history.
void take_outcome(const FinishedRun& run, JobRecord& record) {
  v1::Job& job = record.job;
  job.set_attempts(1);
  *job.mutable_start_time() = timestamp(milliseconds(run.begun));
  *job.mutable_artifacts() = run.finished.artifacts();
  if (run.finished.has_failure()) *job.mutable_failure() = run.finished.failure();
  for (const v1::JobEvent& event : run.events) {
    if (event.has_validity_lost()) *job.mutable_validity_loss() = event.validity_lost();
    if (event.has_finding()) keep_finding(*job.mutable_findings(), event.finding());
  }
}

void move_results(const FinishedRun& run, const std::filesystem::path& folder) {
  for (const v1::Artifact& artifact : run.finished.artifacts())
    std::filesystem::rename(run.folder / artifact.name(), folder / artifact.name());
}

}  // namespace

void Scheduler::write_history(const JobRecord& record, const FinishedRun& run) {
  const auto log = logs_.open(record.job.id());
  v1::JobEvent begun = state_event(record.job, "computed by a query");
  begun.mutable_state_change()->set_state(v1::RUNNING);
  log->append(begun);
  for (v1::JobEvent event : run.events) log->append(event);
}

/// Removes a job that nobody has heard of. What cannot be removed is computed after the next start.
void Scheduler::forget(const std::string& id) {
  try {
    store_.erase(id);
    std::filesystem::remove_all(jobs_directory_ / id);
  } catch (const std::exception& error) {
    spdlog::error("job {}: {}", id, error.what());
  }
}

v1::Job Scheduler::keep(const NewJob& new_job, const Attachments& attachments,
                        const FinishedRun& run) {
  JobRecord record = record_of_new(new_job, attachments);
  record.job.set_id(run.id);
  require_room(record.bytes);
  // Queued on the disk and in no queue here: should the machine stop now, it is computed again.
  write_new_job(record, new_job, attachments);
  try {
    write_history(record, run);
    move_results(run, jobs_directory_ / run.id);
  } catch (...) {
    forget(run.id);
    throw;
  }
  take_outcome(run, record);
  const bool succeeded = run.finished.outcome() == v1::WorkerMessage::Finished::SUCCEEDED;
  if (succeeded) record.solver = options_.attempts.solver;
  const std::lock_guard lock(mutex_);
  ledger_.settle(record, succeeded ? v1::SUCCEEDED : v1::FAILED,
                 succeeded ? "finished" : run.finished.failure().message());
  take_news();
  return view(std::move(record));
}

}  // namespace dccast::jobs
