#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/attempts.hpp"
#include "server/jobs/event_logs.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/job_queue.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/ledger.hpp"
#include "server/jobs/queue_hold.hpp"
#include "server/jobs/tally.hpp"

namespace dccast::jobs {

struct SchedulerOptions {
  AttemptOptions attempts;
  int maximum_queued = 10000;                       ///< jobs that may wait
  std::int64_t maximum_waiting_bytes = 4000000000;  ///< cases and attachments of unfinished jobs
  std::int64_t minimum_free_bytes = 0;              ///< below it no job is taken or started
  std::chrono::seconds share_half_life{86400};      ///< see JobQueue
  int maximum_running_per_user = 0;                 ///< 0: no limit
};

struct QueueFull : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct RequestIdTaken : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct ShuttingDown : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// The daemon's disk takes no new job now.
struct StorageHeld : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Outcome of a request about one job.
struct Reply {
  enum class Kind {
    done,
    not_found,
    wrong_state,
    being_cancelled,  ///< it will be in the right state as soon as its worker has left
  };
  Kind kind = Kind::done;
  v1::Job job;  ///< as it is now, unless not_found
};

/// The queue and its policy: takes jobs, orders them, has them tried, answers requests about them.
/// What a job is stands in the Ledger, what its worker does in the Attempts.
///
/// Safe to use from several threads. A request that throws has changed nothing: it throws
/// StoreError or std::system_error when the disk refuses. No thread waits for the disk while it
/// holds the mutex: what changes a job holds the job instead (Exclusive), and readers see the job
/// as it was until the change is on the disk.
class Scheduler {
public:
  Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor);
  ~Scheduler();

  /// Puts in order what the last daemon left: lets store and event logs agree, goes on with the
  /// workers that the executor finds again, puts the other running jobs back into the queue,
  /// quarantines unknown folders.
  void recover();
  /// Begins to run jobs.
  void start();
  /// Stops running jobs at a checkpoint and puts them back into the queue; returns when all workers
  /// are gone. Nothing is submitted or started any more.
  void shut_down();

  /// Stops at once and leaves running jobs to their workers, for the next daemon to go on with.
  /// Nothing is submitted, started or ended any more.
  void let_workers_run();

  /// Takes a job; it is on the disk when this returns. The same request_id and case give the same
  /// job. @throws QueueFull, RequestIdTaken, ShuttingDown, StorageHeld
  v1::Job submit(const NewJob& new_job, const Attachments& attachments);
  std::optional<v1::Job> find(const std::string& id);
  /// The event log of a job that exists.
  std::shared_ptr<EventLog> log(const std::string& id);
  std::vector<v1::Job> list(const JobStore::Page& page);
  /// See Ledger::observe().
  void observe(JobObserver observer) { ledger_.observe(std::move(observer)); }
  /// See Ledger::observe_transitions(); before recover().
  void observe_transitions(TransitionObserver observer) {
    ledger_.observe_transitions(std::move(observer));
  }
  Reply cancel(const std::string& id, const std::string& reason) {
    return stop(id, {RequestedAction::cancel, reason});
  }
  Reply pause(const std::string& id) { return stop(id, {RequestedAction::pause, ""}); }
  Reply resume(const std::string& id);
  /// @param why      for the log
  /// @param permits  false: the job stays, and is in the wrong state for this
  Reply remove(const std::string& id, const std::string& why = "by request",
               const std::function<bool(const v1::Job& job)>& permits = {});
  /// Changes labels, and whether the job is kept for good. What `change` throws leaves the job as
  /// it was.
  Reply mark(const std::string& id, const std::function<void(v1::Job& job)>& change);
  /// Whether a job waits for this one to succeed.
  bool is_awaited(const std::string& id);
  /// Has the thread of the queue make a round. @return whether it began one in time; false when it
  /// hangs, for example on a disk. Does not return while another thread hangs with the mutex.
  bool turns(std::chrono::milliseconds longest);
  int queued();
  int running();
  /// Why nothing is started now; empty when nothing holds the queue.
  std::string held();

private:
  using Clock = std::chrono::steady_clock;

  /// Holds a job for one thread. Made and ended with the mutex; it may be released in between.
  class Exclusive {
  public:
    Exclusive(Scheduler& scheduler, std::unique_lock<std::mutex>& lock, const std::string& id);
    Exclusive(const Exclusive&) = delete;
    ~Exclusive();

  private:
    Scheduler& scheduler_;
    std::unique_lock<std::mutex>& lock_;
    const std::string id_;
  };

  void run();

  // The functions below expect mutex_ to be held.
  void hold(const std::string& reason);
  v1::Job view(JobRecord record) const;
  v1::Job view(const Attempt& attempt) const;
  bool may_start() const;
  void charge(const v1::Job& job, std::int64_t at_ms);
  void charge_recent_use();
  void enqueue(const v1::Job& job, bool goes_first = false);
  void dequeue(const std::string& id);
  void forget_dependent(const std::string& id);
  void look_at_those_after(const std::string& id);
  bool user_may_start(const std::string& owner) const;
  std::optional<std::string> next_job() const;
  void foresee(v1::Job& job) const;

  // Before there are other threads.
  bool recover_job(JobRecord& record);
  /// @return whether a worker goes on with the job
  bool find_worker_or_settle(JobRecord& record);

  // These take mutex_ themselves, and wait for the disk without it.
  void settle_dependents();
  void settle_dependent(const std::string& id, const std::vector<std::string>& after);
  void conclude_ended();
  void conclude(const std::shared_ptr<Attempt>& attempt);
  bool start_next();
  std::pair<JobRecord, std::shared_ptr<EventLog>> begin_attempt(const std::string& id);
  void refuse_start(const std::string& id, const std::exception& error);
  void look_whether_hold_has_passed();
  void require_room(std::int64_t bytes);
  std::optional<v1::Job> write_new_job(const JobRecord& record, const NewJob& new_job,
                                       const Attachments& attachments);

  /// At once where no worker has the job, else by a request in its folder.
  Reply stop(const std::string& id, const Request& request);

  // Holds the job, and releases `lock` while it waits for the disk.
  Reply settle_idle(std::unique_lock<std::mutex>& lock, JobRecord& record, v1::JobState to,
                    const std::string& cause);

  const SchedulerOptions options_;
  const std::filesystem::path jobs_directory_;
  JobStore& store_;
  EventLogs& logs_;
  Executor& executor_;

  std::mutex mutex_;
  std::condition_variable changed_;
  Ledger ledger_;
  Attempts attempts_;
  JobQueue queue_;
  Forecast forecast_;
  mutable std::vector<double> left_s_;  ///< of the jobs that run, as of `left_at_`
  mutable Clock::time_point left_at_{};
  std::map<std::string, std::vector<std::string>> dependents_;  ///< jobs that wait, and for which
  std::map<std::string, std::set<std::string>> awaited_by_;     ///< the same from the other side
  std::set<std::string> to_look_at_;  ///< of those that wait: may go on, or never will
  QueueHold hold_;
  std::set<std::string> held_jobs_;  ///< see Exclusive
  int submissions_under_way_ = 0;
  bool shutting_down_ = false;
  bool stopping_ = false;            ///< the thread's end
  bool round_requested_ = false;     ///< see turns()
  Clock::time_point expected_wake_;  ///< of the thread
  std::thread thread_;
};

}  // namespace dccast::jobs
