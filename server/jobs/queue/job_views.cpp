#include "server/jobs/queue/job_views.hpp"

#include <fmt/ranges.h>

#include <utility>

#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

using Clock = std::chrono::steady_clock;

v1::Job JobViews::view(JobRecord record) {
  // An end that is written counts, although its attempt may still be there.
  const auto attempt = state_.attempts.find(record.job.id());
  if (attempt && !is_terminal(record.job.state())) return view(*attempt);

  v1::Job job = std::move(record.job);
  const bool queued = job.state() == v1::QUEUED;
  job.set_queue_position(queued ? state_.queue.position(job.id()) : 0);
  if (!queued) return job;

  if (state_.queue_hold.holds())
    job.set_held(state_.queue_hold.reason());
  else if (state_.dependents.contains(job.id()))
    job.set_held(fmt::format("waits for {}", fmt::join(job.after(), ", ")));
  else if (!state_.user_may_start(job.owner()))
    job.set_held(fmt::format("{} has {} jobs running; maximum_running_per_user = {}", job.owner(),
                             state_.attempts.of_queue(job.owner()),
                             state_.options.maximum_running_per_user));
  else
    foresee(job);
  return job;
}

v1::Job JobViews::view(const Attempt& attempt) const {
  v1::Job job = attempt.record.job;
  attempt.log->complete(job);
  job.set_held(attempt.waits.empty() ? attempt.stopped_for : attempt.waits);

  const double left_s = forecast_.left_s(job, ran_s(attempt, Clock::now()));
  if (job.state() == v1::RUNNING && attempt.waits.empty() && left_s > 0.0)
    job.set_ends_in_s(left_s);
  return job;
}

/// When a job of the queue starts and ends, from what jobs took before. What holds a job has no end
/// that could be known: this is for jobs that nothing holds.
void JobViews::foresee(v1::Job& job) {
  const double own_s = forecast_.run_s(job.estimated_s());
  const double each_s = forecast_.run_s(state_.queue.mean_estimated_s());
  if (own_s <= 0.0 || job.queue_position() == 0) return;

  job.set_starts_in_s(
      Forecast::start_s(remaining_s(), state_.executor.capacity(), job.queue_position(), each_s));
  job.set_ends_in_s(job.starts_in_s() + own_s);
}

/// Kept for a moment: a list asks for each of its jobs.
const std::vector<double>& JobViews::remaining_s() {
  constexpr std::chrono::milliseconds good_for{500};
  const auto now_at = Clock::now();
  if (now_at <= remaining_at_ + good_for) return remaining_s_;

  remaining_at_ = now_at;
  remaining_s_.clear();
  for (const auto& [id, attempt] : state_.attempts.by_job())
    if (!attempt->goes_first)
      remaining_s_.push_back(forecast_.left_s(view(*attempt), ran_s(*attempt, now_at)));
  return remaining_s_;
}

}  // namespace dccast::jobs
