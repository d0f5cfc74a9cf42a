#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/event_logs.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/job_queue.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/run.hpp"

namespace dccast::jobs {

struct SchedulerOptions {
  std::filesystem::path jobs_directory;
  int workers = 1;                              ///< jobs that run at once
  int maximum_queued = 10000;                   ///< jobs that may wait
  int worker_restarts = 2;                      ///< times a job whose worker died is started again
  std::chrono::milliseconds stop_grace{20000};  ///< from the order to stop to the kill
};

/// A case that was found good, ready to become a job.
struct NewJob {
  std::string request_id;  ///< empty: none
  std::string study{};     ///< empty: none
  std::string title;
  v1::Priority priority = v1::NORMAL;
  std::string case_sha256;     ///< of the case as it was submitted, with its attachments
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
};

class QueueFull : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};
class RequestIdTaken : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};
class ShuttingDown : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// What became of a request about one job.
struct Reply {
  enum class Kind { done, not_found, wrong_state };
  Kind kind = Kind::done;
  v1::Job job;  ///< as it is now, unless not_found
};

/// The life of all jobs: takes them, orders them, has them run, settles what becomes of them.
///
/// Every transition goes through one function: event log first, then store, then one line of the
/// program's log with the cause. Safe to use from several threads. Calls throw StoreError or
/// std::system_error when the disk is full or not writable.
class Scheduler {
public:
  Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor);
  ~Scheduler();

  /// Puts in order what the last daemon left: kills stray workers, lets store and event logs agree,
  /// puts running jobs back into the queue, moves folders without a job to quarantine.
  void recover();
  /// Begins to run jobs.
  void start();
  /// Stops running jobs at a checkpoint and puts them back into the queue; returns when all workers
  /// are gone. Nothing is submitted or started any more.
  void shut_down();

  /// Takes a job; it is on the disk when this returns. The same request_id and case give the same
  /// job. @throws QueueFull, RequestIdTaken, ShuttingDown
  v1::Job submit(const NewJob& new_job, const Attachments& attachments);
  std::optional<v1::Job> find(const std::string& id);
  /// The event log of a job that exists.
  std::shared_ptr<EventLog> log(const std::string& id);
  std::vector<v1::Job> list(const JobStore::Page& page);
  Reply cancel(const std::string& id, const std::string& reason);
  Reply pause(const std::string& id);
  Reply resume(const std::string& id);
  Reply remove(const std::string& id);
  int queued();
  int running();

  /// A worker has called; it gets its order to start. @return its run; null for a wrong token
  std::shared_ptr<Run> attach(const v1::WorkerMessage::Hello& hello,
                              std::shared_ptr<WorkerChannel> channel);
  /// Takes what a worker says; never waits for watchers.
  void report(const std::shared_ptr<Run>& run, const v1::WorkerMessage& message);
  /// The link to a worker has ended.
  void detach(const std::shared_ptr<Run>& run);

private:
  using Clock = std::chrono::steady_clock;

  // The functions below expect mutex_ to be held, save the one that runs the thread.
  void run();
  Clock::time_point next_deadline() const;
  void kill_overdue();
  void start_next();
  void start_run(JobRecord record);
  void order_stop(Run& run, bool checkpoint);
  v1::Job view(JobRecord record);
  JobRecord* active_record(const std::string& id);

  /// Event log, then store, then a line in the log; nothing when the job is there already.
  /// @throws StoreError, std::system_error; the record keeps its new state
  void transition(JobRecord& record, v1::JobState to, const std::string& cause);
  /// transition() of a job that a worker has left. When the disk refuses, the job fails with
  /// STORAGE, and it is tried again every second until the disk takes that.
  void settle(JobRecord& record, v1::JobState to, const std::string& cause);
  void retry_settlements();

  void append(Run& run, v1::JobEvent event);
  void finish(Run& run, const v1::WorkerMessage::Finished& finished);
  void settle_stopped(Run& run, const std::string& cause);
  void settle_lost(Run& run, const std::string& how);
  void worker_started(const std::string& job_id, int attempt, ProcessIdentity worker);
  void worker_ended(const std::string& job_id, int attempt, const std::string& how);
  /// A run's process and its link are gone.
  void conclude(const std::shared_ptr<Run>& run, const std::string& how);
  std::string missing_artifact(const Run& run) const;

  void recover_job(JobRecord record);

  const SchedulerOptions options_;
  JobStore& store_;
  EventLogs& logs_;
  Executor& executor_;

  std::mutex mutex_;
  std::condition_variable changed_;
  JobQueue queue_;
  int submissions_under_way_ = 0;
  bool shutting_down_ = false;
  std::map<std::string, std::shared_ptr<Run>> runs_;  ///< by job, until the process is gone
  struct Unsettled {
    JobRecord record;
    std::string cause;
  };
  std::map<std::string, Unsettled> unsettled_;  ///< ended jobs the disk has not taken yet
  Clock::time_point next_retry_{};
  bool stopping_ = false;  ///< the thread's end
  std::thread thread_;
};

}  // namespace dccast::jobs
