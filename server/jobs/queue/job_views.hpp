#pragma once

#include <chrono>
#include <vector>

#include "server/jobs/queue/queue_state.hpp"
#include "server/jobs/queue/tally.hpp"

namespace dccast::jobs {

/// Jobs as clients see them: with their position in the queue, the reason that holds them, and
/// their expected start and end. All functions expect the mutex of the state to be held.
class JobViews {
public:
  explicit JobViews(const QueueState& state) : state_(state) {}

  /// A job that has no attempt under way, or one that has.
  v1::Job view(JobRecord record);
  v1::Job view(const Attempt& attempt) const;
  /// Adds an ended job to the forecast.
  void learn(const v1::Job& job) { forecast_.learn(job); }

private:
  /// Predicts start and end of a queued job that nothing holds, from the run times of earlier jobs.
  void predict(v1::Job& job);
  /// Remaining run times of the running jobs [s], by the forecast; cached for a moment.
  const std::vector<double>& remaining_s();

  const QueueState& state_;
  Forecast forecast_;
  std::vector<double>
      remaining_s_;  ///< of the running jobs of the queue, computed at `remaining_at_`
  std::chrono::steady_clock::time_point remaining_at_{};
};

}  // namespace dccast::jobs
