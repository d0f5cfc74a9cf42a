#pragma once

#include <chrono>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "server/jobs/queue/job_requests.hpp"
#include "server/jobs/queue/job_views.hpp"
#include "server/jobs/queue/queue_state.hpp"

namespace dccast::jobs {

/// The thread of the queue: starts jobs, settles those whose workers have ended, kills workers that
/// hang, and checks whether a hold of the queue has passed.
class QueueLoop {
public:
  QueueLoop(QueueState& state, JobViews& views, JobRequests& requests)
      : state_(state), views_(views), requests_(requests) {}
  /// Shuts the queue down unless it has ended.
  ~QueueLoop();

  /// See Scheduler::refuse_owners().
  void refuse_owners(OwnerRefusal refusal) { owner_refusal_ = std::move(refusal); }
  /// Starts the thread.
  void start();
  /// See Scheduler::shut_down().
  void shut_down();
  /// See Scheduler::let_workers_run().
  void let_workers_run();
  /// See Scheduler::is_responsive().
  bool is_responsive(std::chrono::milliseconds longest);

private:
  using Clock = std::chrono::steady_clock;

  /// The loop: settles what has ended, starts what fits, waits for the next event.
  void run();

  // These expect the mutex of the state to be held.
  bool may_end() const;
  /// Whether a round would change something.
  bool has_work() const;
  /// Whether jobs may start now: no hold, no shutdown.
  bool may_start() const;
  /// The job to start next; empty if none may.
  std::optional<std::string> next_job() const;
  /// Removes an attempt whose outcome has been written. @param record  after its settlement
  void forget_attempt(const Attempt& attempt, const JobRecord& record,
                      const Settlement& settlement);

  // These take the mutex themselves, and wait for the disk without it.
  void settle_ended_attempts();
  /// Decides and writes the outcome of a job whose worker has ended; holds the queue if it cannot
  /// be written.
  void settle_attempt(const std::shared_ptr<Attempt>& attempt);
  /// Outcome of an attempt, from its log and its exit.
  Settlement decide(const Attempt& attempt, JobRecord& record, AttemptFacts facts) const;
  /// Holds the queue if too little space is free, also one without jobs.
  void hold_if_disk_is_full();
  /// Lifts a hold whose reason has gone.
  void resume_after_hold();
  /// Looks at the jobs whose predecessors have changed.
  void release_dependents();
  /// Queues the jobs whose time has come.
  void release_begun();
  /// Queues a job if all jobs before it have succeeded; cancels it if one of them never will.
  void release_dependent(const Dependents::Dependent& dependent);
  /// Cancels the followed castings of owners whose jobs may not run any more.
  void end_castings_of_refused_owners();
  /// Starts the next job. @return whether there may be another job to start
  bool start_next();
  /// Records that a job is running. @return no log if the job does not wait
  std::pair<JobRecord, std::shared_ptr<EventLog>> begin_attempt(const std::string& id);
  /// Lets a job that cannot be started wait for the missing resource; it fails only for its own
  /// files.
  void refuse_start(const std::string& id, const std::exception& error);
  /// Whether the files of a job cannot be read, again and again, while the disk works (EIO).
  bool is_unreadable(const std::string& id, const std::exception& error);

  QueueState& state_;
  JobViews& views_;
  JobRequests& requests_;
  std::map<std::string, int> failed_reads_;  ///< in a row of a job's files, by job; of the thread
  bool stopping_ = false;                    ///< the thread must end at once
  bool round_requested_ = false;             ///< see is_responsive()
  Clock::time_point expected_wake_;          ///< of the thread
  OwnerRefusal owner_refusal_;
  Clock::time_point owners_checked_{};
  Clock::time_point disk_checked_{};
  std::thread thread_;
};

}  // namespace dccast::jobs
