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
#include "server/jobs/queue/settlement.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::jobs {

/// One try at a job, from the start of its worker until what became of the job is on the disk. The
/// scheduler's mutex guards it.
struct Attempt {
  using Clock = std::chrono::steady_clock;

  std::string job_id;
  int number = 0;  ///< counts the attempts at the job from 1
  std::shared_ptr<EventLog> log;
  bool adopted = false;     ///< its worker was started by an earlier daemon
  bool goes_first = false;  ///< beside those that the capacity of the executor permits
  JobRecord record;

  Clock::time_point since;  ///< it has a machine
  Clock::time_point time_limit_at = Clock::time_point::max();
  std::string over_time;  ///< which limit it has reached; empty: none

  std::optional<Clock::time_point> kill_at;
  std::string hung;  ///< why its worker was taken to hang and killed; empty: it was not
  std::optional<WorkerExit> exit;  ///< its process has ended
  std::string waits;               ///< why its worker has no machine yet; empty: it has one
  std::string not_started;         ///< why there never was a worker; empty: there was one
  std::string stopped_for;         ///< what its worker is stopped for; empty: it is not
  Clock::time_point stopped_at;    ///< since when it is; all timers stand still meanwhile

  // Signs of life.
  bool begun = false;               ///< the worker has claimed the folder
  Clock::time_point looked;         ///< when the signs were looked at last
  Clock::time_point last_sign;      ///< when there was a new one; of the start until then
  Clock::time_point last_progress;  ///< when there was a new event
  std::int64_t sign = 0;            ///< time of the claim [ns]
  std::int64_t sequence = 0;        ///< of the last event that was seen
};

/// How long a worker may be silent; from the settings of the daemon.
struct WatchdogLimits {
  std::chrono::milliseconds hello{30000};      ///< from its start to its claim on the folder
  std::chrono::milliseconds heartbeat{60000};  ///< between two signs of life
  std::chrono::milliseconds stall{3600000};    ///< between two events; 0: no limit
};

/// How long the job of an attempt has run, with its attempts before and without the time for which
/// its worker was stopped [s].
double ran_s(const Attempt& attempt, Attempt::Clock::time_point now);

struct AttemptOptions {
  std::filesystem::path jobs_directory;
  int worker_restarts = 2;                       ///< times a job whose worker died is tried again
  std::chrono::milliseconds stop_grace{20000};   ///< from the request to stop to the kill
  std::chrono::milliseconds daemon_patience{0};  ///< a worker runs on without a daemon; 0: it ends
  std::chrono::milliseconds heartbeat_interval{2000};  ///< asked of workers; 0: none
  WatchdogLimits watchdog{};
  v1::OtherVersion other_version = v1::BEGIN_ANEW;
  std::string solver{};         ///< identity of the solver that the workers run; empty: not known
  int job_threads = 1;          ///< of a quarter slab
  int first_threads = 1;        ///< the same for a job that goes first
  double maximum_time_s = 0.0;  ///< of a job's wall time; 0: no limit
  std::int64_t worker_memory_bytes = 0;  ///< most of data; 0: nine tenths of its machine's
  std::int64_t worker_file_bytes = 0;    ///< most of one file; 0: no bound
};

/// The attempts under way: their workers and the signs these give. The scheduler's mutex guards it.
class Attempts {
public:
  using Clock = Attempt::Clock;

  Attempts(AttemptOptions options, Executor& executor);

  /// A job that is RUNNING now. @param adopted  the executor has found its worker; else it is
  ///                                            started with start()
  std::shared_ptr<Attempt> add(JobRecord record, std::shared_ptr<EventLog> log, bool adopted);
  void start(Attempt& attempt);
  void erase(const Attempt& attempt) { attempts_.erase(attempt.job_id); }

  const std::map<std::string, std::shared_ptr<Attempt>>& by_job() const { return attempts_; }
  template <typename Condition>
  int count(const Condition& condition) const {
    return static_cast<int>(std::ranges::count_if(
        attempts_, [&](const auto& entry) { return condition(*entry.second); }));
  }
  /// Those of jobs that still run.
  int running() const {
    return count([](const Attempt& each) { return !each.exit; });
  }
  /// Those that count for the capacity of the executor.
  int of_queue() const {
    return count([](const Attempt& each) { return !each.goes_first; });
  }
  int of_queue(const std::string& owner) const {
    return count(
        [&](const Attempt& each) { return !each.goes_first && each.record.job.owner() == owner; });
  }
  /// The attempt at a job; null when there is none.
  std::shared_ptr<Attempt> find(const std::string& job_id) const;
  /// Those whose processes have ended.
  std::vector<std::shared_ptr<Attempt>> ended() const;

  /// The worker has been requested to stop: it is killed when it has not after a while.
  void expect_stop(Attempt& attempt);
  /// Lets every worker leave at a checkpoint; its job goes back into the queue.
  void stop_all();
  void stop(Attempt& attempt);

  void worker_not_started(const std::string& job_id, int number, const std::string& why);
  /// @param why  empty: it waits no more
  void worker_waits(const std::string& job_id, int number, const std::string& why);
  /// @param why  empty: it goes on
  void worker_stopped(const std::string& job_id, int number, const std::string& why);
  void worker_ended(const std::string& job_id, int number, const WorkerExit& exit);
  /// Every worker of an earlier daemon was added. Until then one may end before it is.
  void end_recovery();

  /// Kills workers that do not leave in time or hang.
  void kill_overdue(Clock::time_point now);
  Clock::time_point next_deadline() const;
  void forgive_silences(Clock::time_point now);

  /// What settle() needs to know of an attempt that has ended.
  AttemptFacts facts_of(const Attempt& attempt) const;
  /// Counts attempts in a row that ended because something could not be written.
  void count_storage_failure(const Attempt& attempt, const Settlement& settlement,
                             std::int64_t reached_step);

private:
  std::filesystem::path folder_of(const Attempt& attempt) const;
  WorkerLaunch launch_of(const Attempt& attempt) const;
  v1::SolveCase order_of(const Attempt& attempt) const;
  void count_time_from(Attempt& attempt, Clock::time_point since);

  const AttemptOptions options_;
  Executor& executor_;
  bool recovering_ = true;
  std::map<std::pair<std::string, int>, WorkerExit> ended_unknown_;  ///< by job and attempt
  bool shutting_down_ = false;
  std::map<std::string, std::shared_ptr<Attempt>> attempts_;  ///< by job
  /// Attempts in a row that ended because something could not be written, and got no further.
  struct StorageFailures {
    int in_a_row = 0;
    std::int64_t reached_step = 0;
  };
  std::map<std::string, StorageFailures> storage_failures_;  ///< by job
};

/// What a job becomes whose worker has gone, from the job's own folder: how its run ended by the
/// log, else how its process did. Waits for the disk.
/// @param exit  nothing: it ended while there was no daemon
/// @throws std::system_error  the log cannot be read or taken over
Settlement settle(JobRecord& record, EventLog& log, const std::filesystem::path& folder,
                  const std::optional<WorkerExit>& exit, AttemptFacts facts);

}  // namespace dccast::jobs
