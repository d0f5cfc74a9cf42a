#include "server/jobs/queue/recovery.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

void Recovery::run() {
  std::vector<JobRecord> waiting, with_worker;
  for (JobRecord& record : state_.store.unfinished()) {
    if (recover_job(record))
      with_worker.push_back(std::move(record));
    else if (record.job.state() == v1::QUEUED)
      waiting.push_back(std::move(record));
  }
  quarantine_unknown_folders(state_.jobs_directory, state_.store.ids());

  const std::lock_guard lock(state_.mutex);
  charge_recent_use();
  learn_from_ended_jobs();

  for (const JobRecord& record : waiting)
    state_.enqueue(record.job, lane_in(state_.jobs_directory / record.job.id()));
  for (JobRecord& record : with_worker) {
    const std::string id = record.job.id();
    const auto attempt = state_.attempts.add(std::move(record), state_.logs.open(id),
                                             lane_in(state_.jobs_directory / id), true);
    if (attempt->record.requested_action != RequestedAction::none)
      state_.attempts.expect_stop(*attempt);
    state_.logs.follow(id);
  }
  state_.attempts.end_recovery();
  for (const std::string& lack : {lack_, state_.ledger.refusal()})
    if (!lack.empty()) state_.hold(lack);
}

/// @return whether a worker continues the job
bool Recovery::recover_job(JobRecord& record) {
  const std::string id = record.job.id();
  try {
    return find_worker_or_settle(record);
  } catch (const StoreError&) {
    throw;
  } catch (const std::exception& error) {
    if (const auto lack = daemon_lacks(error)) {
      // The job stays in the queue and continues from its last checkpoint.
      log::error("job {}: cannot be recovered now; it waits in the queue: {}", id, error.what());
      record.job.set_state(v1::QUEUED);
      lack_ = *lack;
    } else {
      add_failure(record.job, v1::Finding::STORAGE, error.what());
      state_.ledger.settle(record, v1::FAILED, error.what());
    }
    return false;
  }
}

bool Recovery::adopt_worker(const JobRecord& record, v1::JobState state) {
  const v1::Job& job = record.job;
  const WorkerLaunch launch{
      .job_id = job.id(), .attempt = job.attempts(), .folder = state_.jobs_directory / job.id()};
  const bool cancelled = record.requested_action == RequestedAction::cancel;
  const bool wanted = state == v1::RUNNING && !cancelled;
  return state_.executor.adopt(launch, wanted) == Adoption::found;
}

/// @return whether a worker continues the job
bool Recovery::find_worker_or_settle(JobRecord& record) {
  v1::Job& job = record.job;
  const auto folder = state_.jobs_directory / job.id();
  const auto log = state_.logs.open(job.id());
  const auto become = [&](v1::JobState state, const std::string& cause) {
    if (is_terminal(state)) record.bytes = bytes_kept(folder);
    state_.ledger.transition(record, state, cause);
    remove_request(folder);
    if (is_terminal(state)) remove_run_files(folder);
    log->announce();
    return false;
  };

  // An event is written before the row, so the log is never behind the store.
  const EventLogContent content = log->content();
  const v1::JobState state = content.last_state ? content.last_state->state() : job.state();
  job.set_attempts(std::max(job.attempts(), content.attempts));
  const auto request = read_request(folder);
  if (request) record.requested_action = request->action;

  if (adopt_worker(record, state)) {
    log::info("job {}: adopted its running worker", job.id());
    job.set_state(v1::RUNNING);
    return true;
  }

  // The last daemon died between the event and the row.
  if (const auto end = log->terminal_event()) {
    const v1::JobEvent::StateChange& change = end->state_change();
    if (change.has_failure()) *job.mutable_failure() = change.failure();
    *job.mutable_artifacts() = change.artifacts();
    *job.mutable_end_time() = end->time();
    return become(change.state(), "ended just before the last daemon did: " + change.cause());
  }

  if (state == v1::RUNNING || request) {
    const AttemptOptions& options = state_.options.attempts;
    const Settlement settlement = settle(
        record, *log, folder, std::nullopt,
        {.worker_restarts = options.worker_restarts, .other_version = options.other_version});
    return become(settlement.state, settlement.cause);
  }
  if (state != job.state()) become(state, "as in its event log; dccastd was restarted");
  return false;
}

void Recovery::learn_from_ended_jobs() {
  const auto succeeded = state_.store.list({.states = {v1::SUCCEEDED}});  // newest first
  std::for_each(succeeded.rbegin(), succeeded.rend(),
                [this](const JobRecord& record) { views_.learn(record.job); });
}

/// Charges owners for the jobs of the last half-lives; older jobs hardly count.
void Recovery::charge_recent_use() {
  constexpr int half_lives = 7, most_jobs = 10000;
  const auto half_life = state_.options.share_half_life;
  if (half_life.count() == 0) return;

  JobStore::Page page{.states = {v1::SUCCEEDED, v1::FAILED, v1::CANCELLED}, .size = most_jobs};
  page.since_ms = milliseconds(now()) - std::chrono::milliseconds(half_lives * half_life).count();
  for (const JobRecord& record : state_.store.list(page)) {
    const std::int64_t at_ms = milliseconds(record.job.end_time());
    state_.queue.charge(record.job.owner(), record.job.attempts() * JobQueue::start_charge_s,
                        at_ms);
    state_.charge(record.job, at_ms);
  }
}

}  // namespace dccast::jobs
