// What the last daemon left: jobs whose workers have ended meanwhile become what their folders
// have.
#include <algorithm>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

void Scheduler::recover() {
  std::vector<JobRecord> waiting, with_worker;
  for (JobRecord& record : store_.unfinished()) {
    if (recover_job(record))
      with_worker.push_back(std::move(record));
    else if (record.job.state() == v1::QUEUED)
      waiting.push_back(std::move(record));
  }
  quarantine_unknown_folders(jobs_directory_, store_.ids());
  const std::lock_guard lock(mutex_);
  charge_recent_use();
  const auto succeeded = store_.list({.states = {v1::SUCCEEDED}});  // newest first
  std::for_each(succeeded.rbegin(), succeeded.rend(),
                [this](const JobRecord& record) { forecast_.learn(record.job); });
  for (const JobRecord& record : waiting) enqueue(record.job);
  for (JobRecord& record : with_worker) {
    const std::string id = record.job.id();
    const auto attempt = attempts_.add(std::move(record), logs_.open(id), true);
    if (attempt->record.requested_action != RequestedAction::none) attempts_.expect_stop(*attempt);
    logs_.follow(id);
  }
  attempts_.end_recovery();
  if (const std::string refusal = ledger_.refusal(); !refusal.empty()) hold(refusal);
}

bool Scheduler::recover_job(JobRecord& record) {
  const std::string id = record.job.id();
  try {
    return find_worker_or_settle(record);
  } catch (const StoreError&) {
    throw;
  } catch (const std::exception& error) {
    if (const auto lack = daemon_lacks(error)) {
      // It waits as it is, and goes on from its last checkpoint.
      log::error("job {}: {}", id, error.what());
      record.job.set_state(v1::QUEUED);
      ledger_.keep(record, *lack);
    } else {
      add_failure(record.job, v1::Failure::STORAGE, error.what());
      ledger_.settle(record, v1::FAILED, error.what());
    }
    return false;
  }
}

bool Scheduler::find_worker_or_settle(JobRecord& record) {
  v1::Job& job = record.job;
  const auto folder = jobs_directory_ / job.id();
  const auto log = logs_.open(job.id());
  const auto become = [&](v1::JobState state, const std::string& cause) {
    ledger_.transition(record, state, cause);
    remove_request(folder);
    if (is_terminal(state)) remove_run_files(folder);
    log->announce();
    return false;
  };
  // An event is written before the store is: the log is never behind.
  const EventLogContent content = log->content();
  const v1::JobState state = content.last_state ? content.last_state->state() : job.state();
  job.set_attempts(std::max(job.attempts(), content.attempts));
  const WorkerLaunch launch{.job_id = job.id(), .attempt = job.attempts(), .folder = folder};
  const auto request = read_request(folder);
  if (request) record.requested_action = request->action;
  const bool cancelled = record.requested_action == RequestedAction::cancel;
  if (executor_.adopt(launch, state == v1::RUNNING && !cancelled) == Adoption::found) {
    log::info("job {}: its worker was found again", job.id());
    job.set_state(v1::RUNNING);
    return true;
  }
  if (const auto end = log->terminal_event()) {  // the daemon died before it told the store
    const v1::JobEvent::StateChange& change = end->state_change();
    if (change.has_failure()) *job.mutable_failure() = change.failure();
    *job.mutable_artifacts() = change.artifacts();
    *job.mutable_end_time() = timestamp(milliseconds(end->time()));
    return become(change.state(), "ended just before the last daemon did: " + change.cause());
  }
  if (state == v1::RUNNING || request) {
    const Settlement settlement = settle(record, *log, folder, std::nullopt,
                                         {.worker_restarts = options_.attempts.worker_restarts,
                                          .other_version = options_.attempts.other_version});
    return become(settlement.state, settlement.cause);
  }
  if (state != job.state()) become(state, "as in its event log; dccastd was restarted");
  return false;
}

/// Of the jobs of some half-lives; older ones count next to nothing.
void Scheduler::charge_recent_use() {
  constexpr int half_lives = 7, most_jobs = 10000;
  if (options_.share_half_life.count() == 0) return;
  JobStore::Page page{.states = {v1::SUCCEEDED, v1::FAILED, v1::CANCELLED}, .size = most_jobs};
  page.since_ms = milliseconds(now()) -
                  std::chrono::milliseconds(half_lives * options_.share_half_life).count();
  for (const JobRecord& record : store_.list(page)) {
    const std::int64_t at_ms = milliseconds(record.job.end_time());
    queue_.charge(record.job.owner(), record.job.attempts() * JobQueue::start_charge_s, at_ms);
    charge(record.job, at_ms);
  }
}

}  // namespace dccast::jobs
