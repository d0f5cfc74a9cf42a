#pragma once

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
  bool recover_job(JobRecord& record);
  bool find_worker_or_settle(JobRecord& record);
  bool adopt_worker(const JobRecord& record, v1::JobState state);
  void learn_from_ended_jobs();
  void charge_recent_use();

  QueueState& state_;
  JobViews& views_;
};

}  // namespace dccast::jobs
