#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/executors/executor.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/queue/lane.hpp"
#include "server/jobs/queue/settlement.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// One attempt at a job, from the start of its worker until the outcome is on the disk. Guarded by
/// the scheduler's mutex.
struct Attempt {
  using Clock = std::chrono::steady_clock;

  std::string job_id;
  int number = 0;  ///< attempts at the job are counted from 1
  std::shared_ptr<EventLog> log;
  bool adopted = false;  ///< its worker was started by an earlier daemon
  Lane lane = Lane::job;
  JobRecord record;

  Clock::time_point since;  ///< when it got its machine
  Clock::time_point time_limit_at = Clock::time_point::max();
  std::string over_time;  ///< its run time if it has reached its limit; empty: it has not
  std::string unfed;      ///< how long no reading came, if that is too long; empty: it is not

  std::optional<Clock::time_point> kill_at;
  std::string hung;                ///< why its worker was killed as hanging; empty: it was not
  std::optional<WorkerExit> exit;  ///< set when its process has ended
  std::string waits;               ///< why its worker has no machine yet; empty: it has one
  std::string not_started;         ///< why no worker was started; empty: one was
  std::string stopped_for;         ///< why its worker is stopped; empty: it is not
  Clock::time_point stopped_at;    ///< when it was stopped; all timers pause meanwhile

  // Heartbeats.
  bool begun = false;               ///< the worker has claimed the folder
  Clock::time_point looked;         ///< time of the last check
  Clock::time_point last_sign;      ///< time of the last heartbeat, at first of the start
  Clock::time_point last_progress;  ///< time of the last event
  std::int64_t sign = 0;            ///< time of the claim [ns]
  std::int64_t sequence = 0;        ///< of the last event
};

/// Longest silences of a worker, from the settings of the daemon.
struct WatchdogLimits {
  std::chrono::milliseconds hello{30000};      ///< from its start to its claim on the folder
  std::chrono::milliseconds heartbeat{60000};  ///< between two heartbeats
  std::chrono::milliseconds stall{3600000};    ///< between two events; 0: no limit

  /// Longest time between two events of a job that follows a casting: its source may pause. 0: no
  /// limit.
  std::chrono::milliseconds reading() const { return 6 * stall; }
};

/// Run time of an attempt's job, with its earlier attempts and without the time for which its
/// worker was stopped [s].
double ran_s(const Attempt& attempt, Attempt::Clock::time_point now);

/// Settings of the daemon for attempts.
struct AttemptOptions {
  std::filesystem::path jobs_directory;
  int worker_restarts = 2;                             ///< restarts of a job whose worker died
  std::chrono::milliseconds stop_grace{20000};         ///< from the request to stop to the kill
  std::chrono::milliseconds daemon_patience{0};        ///< a worker runs so long without a daemon
  std::chrono::milliseconds heartbeat_interval{2000};  ///< asked of workers; 0: none
  WatchdogLimits watchdog{};
  v1::OtherVersion other_version = v1::BEGIN_ANEW;
  std::string solver{};         ///< identity of the solver that the workers run; empty: not known
  int job_threads = 1;          ///< threads of a quarter slab
  int first_threads = 1;        ///< the same for a job with `goes_first`
  double maximum_time_s = 0.0;  ///< of a job's wall time; 0: no limit
  std::int64_t worker_memory_bytes = 0;  ///< limit of its data; 0: 90 % of the machine's memory
  std::int64_t worker_file_bytes = 0;    ///< limit of one file; 0: none
};

/// The attempts under way, with the heartbeats of their workers. Guarded by the scheduler's mutex.
class Attempts {
public:
  using Clock = Attempt::Clock;

  /// @param executor  starts and stops the workers; outlives this object
  Attempts(AttemptOptions options, Executor& executor);

  /// Adds an attempt at a job that is RUNNING now.
  /// @param adopted  the executor has found its worker; otherwise start() starts it
  std::shared_ptr<Attempt> add(JobRecord record, std::shared_ptr<EventLog> log, Lane lane,
                               bool adopted);
  /// Starts the worker of an attempt that was added.
  void start(Attempt& attempt);
  /// Forgets an attempt whose outcome is on the disk.
  void erase(const Attempt& attempt) { attempts_.erase(attempt.job_id); }

  /// All attempts, with those that have ended and are not settled yet.
  const std::map<std::string, std::shared_ptr<Attempt>>& by_job() const { return attempts_; }
  /// Number of attempts for which a condition holds.
  template <typename Condition>
  int count(const Condition& condition) const {
    return static_cast<int>(std::ranges::count_if(
        attempts_, [&](const auto& entry) { return condition(*entry.second); }));
  }
  /// Number of attempts whose process still runs.
  int running() const {
    return count([](const Attempt& each) { return !each.exit; });
  }
  /// Number of attempts of a lane.
  int count_in(Lane lane) const {
    return count([&](const Attempt& each) { return each.lane == lane; });
  }
  /// The same of one owner.
  int count_in(Lane lane, const std::string& owner) const {
    return count(
        [&](const Attempt& each) { return each.lane == lane && each.record.job.owner() == owner; });
  }
  /// The attempt at a job; null if there is none.
  std::shared_ptr<Attempt> find(const std::string& job_id) const;
  /// The attempts whose processes have ended.
  std::vector<std::shared_ptr<Attempt>> ended() const;

  /// Notes that the worker was requested to stop; it is killed after the grace time.
  void expect_stop(Attempt& attempt);
  /// Requests every worker to stop at a checkpoint; the jobs go back into the queue.
  void stop_all();
  /// Requests one worker to stop at a checkpoint.
  void stop(Attempt& attempt);

  /// Reports of the executor about the worker of an attempt; those about an unknown one are kept
  /// until recovery has ended.
  /// @param number  of the attempt
  void worker_not_started(const std::string& job_id, int number, const std::string& why);
  /// @param why  empty: it no longer waits
  void worker_waits(const std::string& job_id, int number, const std::string& why);
  /// @param why  empty: it continues
  void worker_stopped(const std::string& job_id, int number, const std::string& why);
  /// @param exit  how its process has ended
  void worker_ended(const std::string& job_id, int number, const WorkerExit& exit);
  /// Announces that every worker of an earlier daemon was added. Until then, one may end first.
  void end_recovery();

  /// Kills workers that hang or do not stop in time.
  void kill_overdue(Clock::time_point now);
  /// When kill_overdue() has something to do next.
  Clock::time_point next_deadline() const;
  /// After the machine slept: silences that it caused do not count.
  void forgive_silences(Clock::time_point now);

  /// Collects the input of settle() for an attempt that has ended.
  AttemptFacts facts(const Attempt& attempt) const;
  /// Counts attempts in a row that ended because something could not be written.
  void count_storage_failure(const Attempt& attempt, const Settlement& settlement,
                             std::int64_t reached_step);

private:
  /// Folder of its job.
  std::filesystem::path folder(const Attempt& attempt) const;
  /// What the executor needs to know of a worker.
  WorkerLaunch make_launch(const Attempt& attempt) const;
  /// The order to the worker: case, limits, heartbeat.
  v1::SolveCase make_order(const Attempt& attempt) const;
  /// Starts the time limit of a job. @param since  when it got its machine
  void start_timer(Attempt& attempt, Clock::time_point since);

  const AttemptOptions options_;
  Executor& executor_;
  bool recovering_ = true;
  std::map<std::pair<std::string, int>, WorkerExit> ended_unknown_;  ///< by job and attempt
  bool shutting_down_ = false;
  std::map<std::string, std::shared_ptr<Attempt>> attempts_;  ///< by job
  /// Consecutive attempts that ended because a write failed, and made no progress.
  struct StorageFailures {
    /// Since the last attempt that made progress, and the step that one had reached.
    int in_a_row = 0;
    std::int64_t reached_step = 0;
  };
  std::map<std::string, StorageFailures> storage_failures_;  ///< by job
};

/// Decides the outcome of a job whose worker has ended, from the end of the run in its event log,
/// or else from the exit of its process. Waits for the disk.
/// @param exit  nothing: the worker ended while no daemon was running
/// @throws std::system_error  the log cannot be read or taken over
Settlement settle(JobRecord& record, EventLog& log, const std::filesystem::path& folder,
                  const std::optional<WorkerExit>& exit, AttemptFacts facts);

}  // namespace dccast::jobs
