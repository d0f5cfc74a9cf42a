#pragma once

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

/// Hands jobs to Slurm, on machines that see the folders of jobs at the same paths. There is no
/// connection to a worker: it has its order in the folder of its job (worker_claim.hpp) and writes
/// there. It needs no daemon, and the next one finds it in Slurm by name.
///
/// Slurm shows the state of jobs, the folder is the truth: a worker has ended when the folder shows
/// the end of its run, or when Slurm has seen its end, or when Slurm does not know it and the
/// folder is silent. A job is submitted only when no earlier start of it is left in Slurm. Starts
/// that Slurm shows and that are not led are cancelled: after a crash slurmctld takes jobs for
/// running that had ended before.
///
/// Jobs that go first are not for a queue: the local executor has them.
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

private:
  using Clock = std::chrono::steady_clock;

  /// A start that was ordered and has not ended.
  struct Start {
    WorkerLaunch launch;
    bool submitted = false;
    bool stop = false;  ///< SIGTERM is wanted
    bool kill = false;
    bool of_machine = false;  ///< it is cancelled because Slurm cannot start it
    bool waits = false;       ///< as it was reported last
    FolderSigns signs{};
    Clock::time_point last_sign{};
    Clock::time_point last_listed{};  ///< by Slurm, or submitted
    Clock::time_point last_signal{};
    std::optional<Clock::time_point> ended{};  ///< in Slurm, as far as was seen
    SlurmName name() const { return {launch.job_id, launch.attempt}; }
  };
  /// How a start has ended.
  struct End {
    WorkerExit exit;
    bool not_started = false;
  };
  using Key = std::pair<std::string, int>;

  void post(std::function<void()> order);
  void lead(const WorkerLaunch& launch, bool submitted);
  void want(const std::string& job_id, int attempt, bool Start::*what);
  void end_thread();
  void run();
  void look();
  /// What is known of a start. @param jobs  null: Slurm gives no answer, for the reason `fault_`
  /// @return how it has ended
  std::optional<End> follow(Start& start, const SlurmJobs* jobs);
  std::optional<End> submit(Start& start, const SlurmJobs& jobs);
  std::optional<End> follow_listed(Start& start, const SlurmJob& job);
  std::optional<End> follow_ended(Start& start, const SlurmJob& job);
  std::optional<End> follow_absent(Start& start);
  void report_waiting(Start& start, const std::string& why);
  void cancel_strays(const SlurmJobs& jobs);
  bool is_silent(const Start& start) const;
  bool shows_end(const Start& start) const;

  Executor& local_;
  const SlurmOptions options_;
  Calls calls_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> orders_;

  // Of the thread alone.
  bool stopping_ = false;
  std::map<Key, Start> starts_;
  bool adopts_ = true;  ///< what Slurm has may still be adopted
  Clock::time_point last_look_{};
  std::string fault_;  ///< why Slurm gives no answer; empty: it does
  std::thread thread_;
};

}  // namespace dccast::jobs
