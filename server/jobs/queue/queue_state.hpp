#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/queue/attempts.hpp"
#include "server/jobs/queue/dependents.hpp"
#include "server/jobs/queue/job_queue.hpp"
#include "server/jobs/queue/ledger.hpp"
#include "server/jobs/queue/queue_hold.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

struct SchedulerOptions {
  AttemptOptions attempts;
  int maximum_queued = 10000;                       ///< jobs that may wait
  std::int64_t maximum_waiting_bytes = 4000000000;  ///< cases and attachments of unfinished jobs
  std::int64_t minimum_free_bytes = 0;              ///< below it no job is taken or started
  std::chrono::seconds share_half_life{86400};      ///< see JobQueue
  int maximum_running_per_user = 0;                 ///< 0: no limit
};

/// What the parts of the scheduler share: the jobs that wait and those that run. The mutex guards
/// what stands below it, and the member functions expect it to be held.
///
/// No thread waits for the disk while it holds the mutex: what changes a job holds the job instead
/// (ExclusiveJob), and readers see the job as it was until the change is on the disk.
struct QueueState {
  QueueState(SchedulerOptions scheduler_options, JobStore& job_store, EventLogs& event_logs,
             Executor& of_workers);

  /// Starts nothing until the daemon is able to work again.
  void hold(const std::string& reason);
  /// Puts a job into the queue, or beside it until the jobs before it have succeeded.
  void enqueue(const v1::Job& job, bool goes_first = false);
  void dequeue(const std::string& id);
  /// Charges the owner for what a job has taken of the processors, beyond what was charged for its
  /// starts.
  void charge(const v1::Job& job, std::int64_t at_ms);
  /// Kept queries are beside the queue and do not count.
  bool user_may_start(const std::string& owner) const;
  int waiting() const { return static_cast<int>(queue.size()) + dependents.size(); }

  const SchedulerOptions options;
  const std::filesystem::path jobs_directory;
  JobStore& store;
  EventLogs& logs;
  Executor& executor;
  Ledger ledger;  ///< has a lock of its own

  std::mutex mutex;
  std::condition_variable changed;
  Attempts attempts;
  JobQueue queue;
  Dependents dependents;
  QueueHold queue_hold;
  std::set<std::string> held_jobs;  ///< see ExclusiveJob
  bool shutting_down = false;
};

/// Holds a job for one thread. Made and ended with the mutex held; it may be released in between.
class ExclusiveJob {
public:
  ExclusiveJob(QueueState& state, std::unique_lock<std::mutex>& lock, const std::string& id);
  ExclusiveJob(const ExclusiveJob&) = delete;
  ~ExclusiveJob();

private:
  QueueState& state_;
  std::unique_lock<std::mutex>& lock_;
  const std::string id_;
};

}  // namespace dccast::jobs
