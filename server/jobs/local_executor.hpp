#pragma once

#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/worker_claim.hpp"

namespace dccast::jobs {

/// Starts workers as child processes of the daemon, and leads on those of the last daemon.
///
/// A worker begins by waiting for its job on its standard input, so that one can be started ahead
/// of its job: loading the program takes longer than a step of a small casting.
///
/// All of them are children of one thread that lives as long as the daemon: the signal a worker
/// gets when its parent dies (PR_SET_PDEATHSIG) counts the death of the parent *thread*. A worker
/// with a job gives that signal up once it has claimed the job's folder (FolderClaim): it outlives
/// the daemon then, and the next one finds it by its claim.
class LocalExecutor : public Executor {
public:
  /// @param worker_program  dccast-worker
  /// @param capacity        workers that may run at once
  LocalExecutor(std::filesystem::path worker_program, int capacity);
  /// Kills what it has started and is still running, unless that was left to itself, and waits for
  /// its end. A worker of an earlier daemon is left to the next one: this one has only tried to
  /// serve, or has ended it before.
  ~LocalExecutor() override;

  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  int capacity() const override { return capacity_; }
  void start(const WorkerLaunch& launch) override;
  void stop(const std::string& job_id, int attempt) override;
  void kill(const std::string& job_id, int attempt) override;
  /// Found is the worker that claims the folder of the job, when it is of this attempt and of the
  /// protocol of this program. Any other that claims the folder is killed.
  Adoption adopt(const WorkerLaunch& launch, bool wanted) override;
  /// Leaves workers that have claimed a folder to the next daemon. No call back comes any more.
  void let_workers_run();

private:
  /// A process that waits for a job, or has one.
  struct Child {
    pid_t process = 0;
    storage::FileDescriptor handle;  ///< pidfd: readable when the process has ended
    storage::FileDescriptor orders;  ///< its standard input, until it has its job
    bool adopted = false;            ///< of an earlier daemon: no child of this process
  };
  using Children = std::map<std::pair<std::string, int>, Child>;
  static std::optional<WorkerExit> exit_of(const Child& child);
  void send_signal(const std::string& job_id, int attempt, int number);
  static void send_signal(const Child& child, int number);
  void end_thread();
  void run();
  void post(std::function<void()> order);
  Child spawn() const;
  void hand_over(const WorkerLaunch& launch);
  void keep_one_ready();
  void wait_for_something();
  void collect();

  const std::filesystem::path worker_program_;
  const int capacity_;
  Calls calls_;
  storage::FileDescriptor wake_;  ///< eventfd
  std::mutex mutex_;
  std::deque<std::function<void()>> orders_;

  // Of the thread alone.
  bool stopping_ = false;
  bool leaves_workers_ = false;
  bool used_ = false;  ///< the one kept ready was handed a job, or there never was one
  std::optional<Child> ready_;
  Children children_;
  std::thread thread_;
};

}  // namespace dccast::jobs
