#include "server/jobs/queue/queue_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/jobs/folder/events.hpp"
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

void QueueState::enqueue(const v1::Job& job, Lane lane) {
  if (!dependents.add(job)) enqueue_at_its_time(job, lane);
}

void QueueState::enqueue_at_its_time(const v1::Job& job, Lane lane) {
  if (!begins.add(job, lane, milliseconds(now()))) queue.push(job, lane);
}

void QueueState::reorder(const v1::Job& job) {
  if (queue.position(job.id()) > 0) {
    const Lane lane = queue.lane_of(job.id());
    queue.erase(job.id());
    queue.push(job, lane);
  } else if (const auto waiting = begins.remove(job.id())) {
    begins.add(job, waiting->lane, 0);
  }
}

void QueueState::dequeue(const std::string& id) {
  queue.erase(id);
  begins.remove(id);
  dependents.remove(id);
  dependents.note_change(id);
}

void QueueState::charge(const v1::Job& job, std::int64_t at_ms) {
  const double taken = std::max(job.last_step().process_s(), job.last_step().solver_s());
  const double charged = job.attempts() * JobQueue::start_charge_s;
  queue.charge(job.owner(), std::max(0.0, taken - charged), at_ms);
}

std::string QueueState::bound_reached(Lane lane, const std::string& owner) const {
  if (lane == Lane::query) return {};

  const int followed = attempts.count_in(Lane::followed, owner);
  const int running = followed + attempts.count_in(Lane::job, owner);
  if (options.maximum_running_per_user > 0 && running >= options.maximum_running_per_user)
    return fmt::format("{} has {} jobs running; per_user.maximum_running = {}", owner, running,
                       options.maximum_running_per_user);
  if (lane != Lane::followed) return {};

  if (followed >= options.maximum_followed_per_user)
    return fmt::format("{} follows {} castings; per_user.maximum_followed = {}", owner, followed,
                       options.maximum_followed_per_user);
  const int of_all = attempts.count_in(Lane::followed);
  if (of_all >= options.maximum_followed)
    return fmt::format("{} castings of all users are followed; limits.maximum_followed = {}",
                       of_all, options.maximum_followed);
  return {};
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
