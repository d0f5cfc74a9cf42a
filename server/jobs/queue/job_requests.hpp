#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/queue/job_views.hpp"
#include "server/jobs/queue/queue_state.hpp"

namespace dccast::jobs {

/// Outcome of a request about one job.
struct Reply {
  enum class Kind {
    done,
    not_found,
    wrong_state,
    being_cancelled,  ///< the state will be right as soon as its worker has ended
  };
  Kind kind = Kind::done;
  v1::Job job;  ///< its present state, unless not_found
};

/// Requests about one job. Safe to use from several threads. A request that throws changes nothing.
class JobRequests {
public:
  JobRequests(QueueState& state, JobViews& views) : state_(state), views_(views) {}

  /// Cancels or pauses a job: at once if no worker runs it, else by a request in its folder.
  Reply stop(const std::string& id, const Request& request);
  /// Puts a paused job back into the queue. wrong_state: it is not paused.
  Reply resume(const std::string& id);
  /// See Scheduler::observe_removal().
  void observe_removal(JobObserver observer) { removal_observer_ = std::move(observer); }
  /// See Scheduler::remove().
  Reply remove(const std::string& id, const std::string& why,
               const std::function<bool(const v1::Job& job)>& permits);
  /// See Scheduler::mark().
  Reply mark(const std::string& id, const std::function<void(v1::Job& job)>& change);

  /// Brings a job that no worker runs into another state. The caller has locked it (ExclusiveJob).
  /// @param lock  released; held only while the queue changes
  Reply settle_idle(std::unique_lock<std::mutex>& lock, JobRecord& record, v1::JobState to,
                    const std::string& cause);

private:
  /// Asks a worker to stop by a request in the folder of its job.
  Reply stop_worker(std::unique_lock<std::mutex>& lock, Attempt& attempt, const Request& request);
  /// Deletes row and folder of a job that no worker runs.
  void erase(const JobRecord& record);

  JobObserver removal_observer_;
  QueueState& state_;
  JobViews& views_;
};

}  // namespace dccast::jobs
