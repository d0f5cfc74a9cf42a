#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/queue/job_requests.hpp"
#include "server/jobs/queue/job_views.hpp"
#include "server/jobs/queue/queue_loop.hpp"
#include "server/jobs/queue/queue_state.hpp"
#include "server/jobs/queue/submissions.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// Interface of the queue: accepts jobs, orders them, runs them, and answers requests about them.
/// Each of these tasks is a class of its own over one QueueState.
///
/// Safe to use from several threads. A request that throws has changed nothing; it throws
/// StoreError or std::system_error if it cannot write.
class Scheduler {
public:
  /// @param executor  starts the workers; all outlive this object
  Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor);

  /// Recovers the state of the last daemon: makes store and event logs agree, adopts the workers
  /// that the executor finds, puts other running jobs back into the queue, quarantines unknown
  /// folders.
  void recover();
  /// Starts to run jobs.
  void start();
  /// Stops running jobs at a checkpoint and puts them back into the queue; returns when all workers
  /// have ended. Nothing is submitted or started any more.
  void shut_down() { loop_.shut_down(); }

  /// Stops at once and leaves running jobs to their workers, which the next daemon adopts. Nothing
  /// is submitted, started or ended any more.
  void let_workers_run() { loop_.let_workers_run(); }

  /// Accepts a job and writes it to disk. The same request_id and case return the same job.
  /// @throws refusal::LimitReached, RequestIdTaken, ShuttingDown, StorageHeld
  v1::Job submit(const NewJob& new_job, const Attachments& attachments) {
    return submissions_.submit(new_job, attachments);
  }
  /// A job as clients see it; empty if there is no such job.
  std::optional<v1::Job> find(const std::string& id);
  /// The event log of a job that exists.
  std::shared_ptr<EventLog> log(const std::string& id);
  /// A page of jobs, newest first.
  std::vector<v1::Job> list(const JobStore::Page& page);
  /// See Ledger::observe().
  void observe(JobObserver observer) { state_.ledger.observe(std::move(observer)); }
  /// See Ledger::observe_transitions(); before recover().
  void observe_transitions(TransitionObserver observer) {
    state_.ledger.observe_transitions(std::move(observer));
  }
  /// Sets the observer of jobs that are about to be deleted, whose folder still exists; before
  /// start(). It must not throw.
  void observe_removal(JobObserver observer) { requests_.observe_removal(std::move(observer)); }
  /// Sets what decides whose castings are followed no more; before start(). The objects that it
  /// uses live until shut_down() or let_workers_run() has returned.
  void refuse_owners(OwnerRefusal refusal) { loop_.refuse_owners(std::move(refusal)); }
  /// Cancels a job; see JobRequests::stop(). @param reason  stored as its cause
  Reply cancel(const std::string& id, const std::string& reason) {
    return requests_.stop(id, {RequestedAction::cancel, reason});
  }
  Reply pause(const std::string& id) { return requests_.stop(id, {RequestedAction::pause, ""}); }
  Reply resume(const std::string& id) { return requests_.resume(id); }
  /// @param why      for the log
  /// @param permits  returns false to keep the job; the reply is then wrong_state
  Reply remove(const std::string& id, const std::string& why = "by request",
               const std::function<bool(const v1::Job& job)>& permits = {}) {
    return requests_.remove(id, why, permits);
  }
  /// Changes labels, priority, and whether the job is pinned. If `change` throws, the job stays
  /// unchanged.
  Reply mark(const std::string& id, const std::function<void(v1::Job& job)>& change) {
    return requests_.mark(id, change);
  }
  /// Whether a job waits for this one to succeed.
  bool is_awaited(const std::string& id);
  /// Wakes the thread of the queue. @return whether it began a round in time; false if it hangs,
  /// for example on a disk. Does not return while another thread hangs with the mutex.
  bool is_responsive(std::chrono::milliseconds longest) { return loop_.is_responsive(longest); }
  /// Numbers of jobs, for status and metrics.
  int queued();
  int running();
  /// Why nothing is started now; empty if nothing holds the queue.
  std::string held();

private:
  QueueState state_;
  JobViews views_;
  Submissions submissions_;
  JobRequests requests_;
  QueueLoop loop_;
};

}  // namespace dccast::jobs
