#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/queue/attempts.hpp"
#include "server/jobs/queue/begins.hpp"
#include "server/jobs/queue/dependents.hpp"
#include "server/jobs/queue/job_queue.hpp"
#include "server/jobs/queue/ledger.hpp"
#include "server/jobs/queue/queue_hold.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// Settings of the daemon for the scheduler.
struct SchedulerOptions {
  AttemptOptions attempts;
  int maximum_queued = 10000;                       ///< limit of waiting jobs
  std::int64_t maximum_waiting_bytes = 4000000000;  ///< cases and attachments of unfinished jobs
  std::int64_t minimum_free_bytes = 0;              ///< below it no job is accepted or started
  std::chrono::seconds share_half_life{86400};      ///< see JobQueue
  int maximum_running_per_user = 0;                 ///< 0: no limit
  int maximum_followed = 10;                        ///< castings that running jobs follow
  int maximum_followed_per_user = 8;
};

/// Why the owner of a job may run it no more, e.g. "user anna is disabled"; empty: it may run. It
/// may wait for the disk.
using OwnerRefusal = std::function<std::string(const v1::Job& job)>;

/// State shared by the parts of the scheduler: waiting and running jobs. The mutex guards the
/// members below it, and the member functions expect it to be held.
///
/// No thread waits for the disk while it holds the mutex. A change of a job locks that job instead
/// (ExclusiveJob), and readers see its old state until the change is on the disk.
struct QueueState {
  /// The store, the logs and the workers outlive this object.
  QueueState(SchedulerOptions scheduler_options, JobStore& job_store, EventLogs& event_logs,
             Executor& of_workers);

  /// Holds the queue until the fault has passed.
  void hold(const std::string& reason);
  /// Queues a job, or lets it wait until the jobs before it have ended, and for its time.
  void enqueue(const v1::Job& job, Lane lane);
  /// The same of a job that waits for no other any more.
  void enqueue_at_its_time(const v1::Job& job, Lane lane);
  /// Gives a queued job the place of its present priority.
  void reorder(const v1::Job& job);
  /// Removes a job from the queue and from those that wait; jobs that wait for it are checked
  /// again.
  void dequeue(const std::string& id);
  /// Charges the owner for the processor time of a job, beyond what was charged at its starts.
  void charge(const v1::Job& job, std::int64_t at_ms);
  /// Why one more job of a lane may not start, besides a lack of places: a bound of its owner or of
  /// its lane, as a sentence with its value; empty: it may. Kept queries have none.
  std::string bound_reached(Lane lane, const std::string& owner) const;
  /// Jobs that have not been started, with those that wait for others or for their time.
  int waiting() const { return static_cast<int>(queue.size()) + dependents.size() + begins.size(); }

  /// Fixed after construction.
  const SchedulerOptions options;
  const std::filesystem::path jobs_directory;
  JobStore& store;
  EventLogs& logs;
  Executor& executor;
  Ledger ledger;  ///< has a lock of its own

  /// Guards all members below.
  std::mutex mutex;
  std::condition_variable changed;
  Attempts attempts;
  JobQueue queue;
  Dependents dependents;
  Begins begins;
  QueueHold queue_hold;
  std::set<std::string> held_jobs;  ///< see ExclusiveJob
  bool shutting_down = false;
};

/// Locks a job for one thread. Created and destroyed with the mutex held, which may be released in
/// between.
class ExclusiveJob {
public:
  /// Waits until no other request changes the job, and keeps others away until destruction.
  ExclusiveJob(QueueState& state, std::unique_lock<std::mutex>& lock, const std::string& id);
  ExclusiveJob(const ExclusiveJob&) = delete;
  ~ExclusiveJob();

private:
  QueueState& state_;
  std::unique_lock<std::mutex>& lock_;
  const std::string id_;
};

}  // namespace dccast::jobs
