#include "server/jobs/recovery.hpp"

#include "server/jobs/log.hpp"

#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/storage_fault.hpp"

namespace dccast::jobs {

namespace {

/// The log knows of an end that the store does not: the daemon died between the two.
void take_over_end(const v1::JobEvent& event, v1::Job& job) {
  if (event.state_change().has_failure()) *job.mutable_failure() = event.state_change().failure();
  *job.mutable_artifacts() = event.state_change().artifacts();
  *job.mutable_end_time() = timestamp(milliseconds(event.time()));
}

/// One job that has not ended as far as the store knows.
class Recovery {
public:
  Recovery(const AttemptOptions& options, EventLogs& logs, Ledger& ledger, Executor& executor,
           JobRecord& record)
      : options_(options),
        ledger_(ledger),
        executor_(executor),
        record_(record),
        folder_(options.jobs_directory / record.job.id()),
        log_(logs.open(record.job.id())) {}

  /// @return whether a worker goes on with it
  bool run() {
    v1::Job& job = record_.job;
    // An event is written before the store is: the log is never behind.
    const EventLogContent content = log_->content();
    const v1::JobState state = content.last_state ? content.last_state->state() : job.state();
    job.set_attempts(std::max(job.attempts(), content.attempts));
    const WorkerLaunch launch{.job_id = job.id(), .attempt = job.attempts(), .folder = folder_};
    const auto request = read_request(folder_);
    if (request) record_.requested_action = request->action;
    const bool cancelled = record_.requested_action == RequestedAction::cancel;
    if (executor_.adopt(launch, state == v1::RUNNING && !cancelled) == Adoption::found) {
      log::info("job {}: its worker was found again", job.id());
      job.set_state(v1::RUNNING);
      return true;
    }
    if (const auto end = log_->terminal_event()) {
      take_over_end(*end, job);
      become(end->state_change().state(),
             "ended just before the last daemon did: " + end->state_change().cause());
    } else if (state == v1::RUNNING || record_.requested_action != RequestedAction::none) {
      const Settlement settlement = settle(
          record_, *log_, folder_, std::nullopt,
          {.worker_restarts = options_.worker_restarts, .other_version = options_.other_version});
      become(settlement.state, settlement.cause);
    } else if (state != job.state()) {
      become(state, "as in its event log; dccastd was restarted");
    }
    return false;
  }

private:
  void become(v1::JobState state, const std::string& cause) {
    ledger_.transition(record_, state, cause);
    remove_request(folder_);
    if (is_terminal(state)) remove_run_files(folder_);
    log_->announce();
  }

  const AttemptOptions& options_;
  Ledger& ledger_;
  Executor& executor_;
  JobRecord& record_;
  const std::filesystem::path folder_;
  const std::shared_ptr<EventLog> log_;
};

}  // namespace

RecoveredJobs recover_jobs(const AttemptOptions& options, JobStore& store, EventLogs& logs,
                           Ledger& ledger, Executor& executor) {
  RecoveredJobs recovered;
  for (JobRecord& record : store.unfinished()) {
    const std::string id = record.job.id();
    try {
      if (Recovery(options, logs, ledger, executor, record).run()) {
        recovered.with_worker.push_back(std::move(record));
        continue;
      }
    } catch (const StoreError&) {
      throw;
    } catch (const std::exception& error) {
      if (const auto lack = daemon_lacks(error)) {
        // It waits as it is, and goes on from its last checkpoint.
        log::error("job {}: {}", id, error.what());
        recovered.daemon_lacks = *lack;
        record.job.set_state(v1::QUEUED);
        ledger.keep(record, *lack);
      } else {
        add_failure(record.job, v1::Failure::STORAGE, error.what());
        ledger.settle(record, v1::FAILED, error.what());
      }
    }
    if (record.job.state() == v1::QUEUED) recovered.waiting.push_back(record.job);
  }
  return recovered;
}

}  // namespace dccast::jobs
