#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "server/jobs/queue/scheduler.hpp"

/// Actions of the daemon on jobs that have ended.
namespace dccast::jobs {

/// Runs an administrator's program once for each job that has ended, one after the other, as
/// `PROGRAM ID STATE` with DCCAST_JOB, DCCAST_STATE, DCCAST_OWNER, DCCAST_TITLE, DCCAST_MAIL and
/// DCCAST_STUDY in its environment. No shell interprets a text of a user. The program is started at
/// most once for a job; jobs that wait when the daemon ends are lost. Safe to use from several
/// threads.
class EndHook {
public:
  /// @param program  empty: none
  /// @param longest  time limit, at which the program and its children are killed
  explicit EndHook(std::string program, std::chrono::seconds longest = std::chrono::seconds(60));
  /// For Ledger::observe_transitions().
  void on_transition(const v1::Job& job, v1::JobState from);

private:
  /// The thread: runs the program for each job in the order in which they ended.
  void run(const std::stop_token& stop);
  /// Runs it for one job and kills it with its children at the time limit.
  void run_program(const v1::Job& job, const std::stop_token& stop) const;

  const std::string program_;
  const std::chrono::seconds longest_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<v1::Job> ended_;
  std::jthread thread_;
};

/// Settings of the daemon for old jobs.
struct RetentionOptions {
  std::chrono::seconds time{0};  ///< jobs that ended longer ago are deleted; 0: never
  std::int64_t bytes =
      0;  ///< disk space of ended jobs, beyond which the oldest are deleted; 0: no limit
  std::chrono::milliseconds interval{10000};
};

/// Deletes old jobs, as a request would. Pinned jobs, jobs of studies and jobs that others wait for
/// stay, and do not count. Deletes nothing while the queue is held.
class Retention {
public:
  /// @param scheduler  deletes the jobs; outlives this object
  Retention(RetentionOptions options, JobStore& store, Scheduler& scheduler);

private:
  /// The thread: deletes at every interval.
  void run(const std::stop_token& stop);
  /// Deletes what is too old, then the oldest until the rest fits.
  void delete_old_jobs();

  const RetentionOptions options_;
  JobStore& store_;
  Scheduler& scheduler_;
  std::jthread thread_;
};

}  // namespace dccast::jobs
