#include "server/jobs/queue/job_views.hpp"

#include <fmt/chrono.h>
#include <fmt/ranges.h>

#include <utility>

#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

using Clock = std::chrono::steady_clock;

namespace {

std::string describe_wait(const v1::Job& job) {
  const char* end = job.after_end() == v1::AWAITED_FAILURE   ? " to fail"
                    : job.after_end() == v1::AWAITED_ANY_END ? " to end"
                                                             : "";
  return fmt::format("waits for {}{}", fmt::join(job.after(), ", "), end);
}

}  // namespace

v1::Job JobViews::view(JobRecord record) {
  // A recorded end counts, even if its attempt still exists.
  const auto attempt = state_.attempts.find(record.job.id());
  if (attempt && !is_terminal(record.job.state())) return view(*attempt);

  v1::Job job = std::move(record.job);
  const bool queued = job.state() == v1::QUEUED;
  job.set_queue_position(queued ? state_.queue.position(job.id()) : 0);
  if (!queued) return job;

  std::string bound;
  if (job.queue_position() > 0)  // just submitted, it may not be in the queue yet
    bound = state_.bound_reached(state_.queue.lane_of(job.id()), job.owner());

  if (state_.queue_hold.holds())
    job.set_held(state_.queue_hold.reason());
  else if (state_.dependents.contains(job.id()))
    job.set_held(describe_wait(job));
  else if (state_.begins.contains(job.id()))
    job.set_held(
        fmt::format("waits until {:%Y-%m-%d %H:%M:%SZ}", fmt::gmtime(job.begin_time().seconds())));
  else if (!bound.empty())
    job.set_held(bound);
  else
    predict(job);
  return job;
}

v1::Job JobViews::view(const Attempt& attempt) const {
  v1::Job job = attempt.record.job;
  attempt.log->complete(job);
  job.set_held(attempt.waits.empty() ? attempt.stopped_for : attempt.waits);

  const double left_s = forecast_.remaining_s(job, ran_s(attempt, Clock::now()));
  if (job.state() == v1::RUNNING && attempt.waits.empty() && left_s > 0.0)
    job.set_ends_in_s(left_s);
  return job;
}

/// Predicts start and end of a queued job from the run times of earlier jobs. Only for jobs that
/// nothing holds, because the end of a hold is not known.
void JobViews::predict(v1::Job& job) {
  const double own_s = forecast_.run_s(job.estimated_s());
  const double each_s = forecast_.run_s(state_.queue.mean_estimated_s());
  if (own_s <= 0.0 || job.queue_position() == 0) return;

  job.set_starts_in_s(
      Forecast::start_s(remaining_s(), state_.executor.capacity(), job.queue_position(), each_s));
  job.set_ends_in_s(job.starts_in_s() + own_s);
}

/// Remaining times of the running jobs. Cached for a moment, because a list asks for each of its
/// jobs.
const std::vector<double>& JobViews::remaining_s() {
  constexpr std::chrono::milliseconds cache_time{500};
  const auto now_at = Clock::now();
  if (now_at <= remaining_at_ + cache_time) return remaining_s_;

  remaining_at_ = now_at;
  remaining_s_.clear();
  for (const auto& [id, attempt] : state_.attempts.by_job())
    if (attempt->lane == Lane::job)
      remaining_s_.push_back(forecast_.remaining_s(view(*attempt), ran_s(*attempt, now_at)));
  return remaining_s_;
}

}  // namespace dccast::jobs
