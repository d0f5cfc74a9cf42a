#include "server/jobs/queue/queue_state.hpp"

#include <algorithm>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::jobs {

QueueState::QueueState(SchedulerOptions scheduler_options, JobStore& job_store,
                       EventLogs& event_logs, Executor& of_workers)
    : options(std::move(scheduler_options)),
      jobs_directory(options.attempts.jobs_directory),
      store(job_store),
      logs(event_logs),
      executor(of_workers),
      ledger(store, logs, jobs_directory),
      attempts(options.attempts, executor),
      queue(options.share_half_life) {}

void QueueState::hold(const std::string& reason) {
  if (queue_hold.set(reason))
    log::error(
        "the queue is held: {}; no job fails because of it; checking again every few seconds",
        reason);
  changed.notify_all();
}

void QueueState::enqueue(const v1::Job& job, bool goes_first) {
  if (!dependents.add(job)) queue.push(job, goes_first);
}

void QueueState::dequeue(const std::string& id) {
  queue.erase(id);
  dependents.remove(id);
  dependents.note_change(id);
}

void QueueState::charge(const v1::Job& job, std::int64_t at_ms) {
  const double taken = std::max(job.last_step().process_s(), job.last_step().solver_s());
  const double charged = job.attempts() * JobQueue::start_charge_s;
  queue.charge(job.owner(), std::max(0.0, taken - charged), at_ms);
}

bool QueueState::user_may_start(const std::string& owner) const {
  return options.maximum_running_per_user == 0 ||
         attempts.count_queued(owner) < options.maximum_running_per_user;
}

ExclusiveJob::ExclusiveJob(QueueState& state, std::unique_lock<std::mutex>& lock,
                           const std::string& id)
    : state_(state), lock_(lock), id_(id) {
  state_.changed.wait(lock_, [this] { return !state_.held_jobs.contains(id_); });
  state_.held_jobs.insert(id_);
}

ExclusiveJob::~ExclusiveJob() {
  if (!lock_.owns_lock()) lock_.lock();
  state_.held_jobs.erase(id_);
  state_.changed.notify_all();
}

}  // namespace dccast::jobs
