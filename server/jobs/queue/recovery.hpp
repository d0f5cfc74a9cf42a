#pragma once

#include <string>

#include "server/jobs/queue/job_views.hpp"
#include "server/jobs/queue/queue_state.hpp"

namespace dccast::jobs {

/// Recovers the jobs of the last daemon: settles those whose workers have ended meanwhile, from
/// their folders, and adopts running workers. Runs before other threads start.
class Recovery {
public:
  Recovery(QueueState& state, JobViews& views) : state_(state), views_(views) {}

  /// See Scheduler::recover().
  void run();

private:
  /// Brings one job of an earlier daemon into a state that this one can continue from.
  /// @return whether a worker continues the job
  bool recover_job(JobRecord& record);
  /// Finds the worker of a job that was running, or settles the job from its folder.
  bool find_worker_or_settle(JobRecord& record);
  /// Takes over a worker that still runs. @return false if it cannot be taken over
  bool adopt_worker(const JobRecord& record, v1::JobState state);
  /// Adds the jobs that have succeeded to the forecast.
  void learn_from_ended_jobs();
  /// Charges the owners for what they have used lately.
  void charge_recent_use();

  QueueState& state_;
  JobViews& views_;
  std::string lack_;  ///< what the daemon lacked to recover a job; empty: nothing
};

}  // namespace dccast::jobs
