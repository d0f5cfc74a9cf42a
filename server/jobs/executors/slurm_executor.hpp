#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "server/jobs/executors/executor.hpp"
#include "server/jobs/executors/slurm_commands.hpp"
#include "server/jobs/executors/worker_claim.hpp"

namespace dccast::jobs {

/// Runs jobs through Slurm, on machines that see the folders of jobs at the same paths. There is no
/// connection to a worker: it reads its order in the folder of its job (worker_claim.hpp) and
/// writes there. It does not depend on the daemon, and the next daemon finds it in Slurm by name.
///
/// Slurm shows the state of jobs, but the folder is authoritative. A worker has ended if the folder
/// shows the end of its run, if Slurm shows its end, or if Slurm does not know it and nothing
/// writes into the folder. A job is submitted only if no earlier start of it is left in Slurm.
/// Starts in Slurm that this executor does not supervise are cancelled, because slurmctld may take
/// ended jobs for running after a crash.
///
/// Jobs with `goes_first` bypass the queue of Slurm: the local executor runs them.
class SlurmExecutor : public Executor {
public:
  /// @param local  outlives this object
  SlurmExecutor(Executor& local, SlurmOptions options);
  ~SlurmExecutor() override { end_thread(); }

  void set_calls(Calls calls) override;
  int capacity() const override { return options_.jobs; }
  void start(const WorkerLaunch& launch) override;
  void stop(const std::string& job_id, int attempt) override;
  void kill(const std::string& job_id, int attempt) override;
  Adoption adopt(const WorkerLaunch& launch, bool wanted) override;
  void end_adoption() override {
    post([this] { adopts_ = false; });
  }
  void let_workers_run() override;
  std::string lacks() const override;

private:
  using Clock = std::chrono::steady_clock;

  /// A start that was requested and has not ended.
  struct Start {
    WorkerLaunch launch;
    bool submitted = false;
    bool stop = false;  ///< a stop (SIGTERM) is requested
    bool kill = false;
    bool of_machine = false;  ///< it is being cancelled because Slurm cannot start it
    bool waits = false;       ///< as last reported
    FolderSigns signs{};
    Clock::time_point last_sign{};
    Clock::time_point last_listed{};  ///< time when Slurm last showed it, or of its submission
    Clock::time_point last_signal{};
    std::optional<Clock::time_point> ended{};  ///< time when Slurm first showed its end
    SlurmName name() const { return {launch.job_id, launch.attempt}; }
  };
  /// End of a start.
  struct End {
    WorkerExit exit;
    bool not_started = false;
  };
  using Key = std::pair<std::string, int>;

  /// Has the thread carry out an order.
  void post(std::function<void()> order);
  /// Begins to follow a start. @param submitted  by an earlier daemon
  void supervise(const WorkerLaunch& launch, bool submitted);
  /// Notes a request for an attempt, which the thread passes on to Slurm.
  void request(const std::string& job_id, int attempt, bool Start::*flag);
  /// Ends the thread; jobs stay in Slurm.
  void end_thread();
  /// The thread: carries out orders and polls Slurm.
  void run();
  /// Compares all starts with what squeue shows.
  void poll();
  /// Updates a start. @param jobs  null: Slurm gives no answer, for the reason `fault_`
  /// @return its end, once it has ended
  std::optional<End> follow(Start& start, const SlurmJobs* jobs);
  /// Submits a start that Slurm does not show. @return its end, if it cannot be submitted
  std::optional<End> submit(Start& start, const SlurmJobs& jobs);
  /// Follows a start that Slurm shows as waiting or running.
  std::optional<End> follow_listed(Start& start, const SlurmJob& job);
  /// Follows one that Slurm shows as ended, until its folder shows the end too.
  std::optional<End> follow_ended(Start& start, const SlurmJob& job);
  /// Decides about one that Slurm no longer shows.
  std::optional<End> follow_absent(Start& start);
  /// Reports why a job waits, or that it no longer does.
  void report_waiting(Start& start, const std::string& why);
  /// Cancels jobs of this daemon in Slurm that it does not follow.
  void cancel_strays(const SlurmJobs& jobs);
  /// Whether the folder has not changed for so long that no worker can be at work.
  bool is_silent(const Start& start) const;
  /// Whether the folder shows that the run has ended.
  bool shows_end(const Start& start) const;

  Executor& local_;
  const SlurmOptions options_;
  Calls calls_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> orders_;

  // Used only by the thread.
  bool stopping_ = false;
  std::map<Key, Start> starts_;
  bool adopts_ = true;  ///< starts in Slurm may still be adopted
  Clock::time_point last_poll_{};
  std::string fault_;  ///< why Slurm gives no answer; empty: it answers

  // Read by any thread.
  std::atomic<int> losses_ = 0;  ///< starts in a row that Slurm lost before their workers began
  std::atomic<Clock::rep> lost_at_ = 0;
  std::thread thread_;
};

}  // namespace dccast::jobs
