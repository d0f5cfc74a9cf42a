#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/executors/warm_workers.hpp"

namespace dccast::jobs {

/// Hands jobs to worker processes of the daemon, and leads on those of the last daemon.
///
/// A worker gives up the signal it gets at the daemon's death once it has claimed the folder of its
/// job (FolderClaim): it outlives the daemon then, and the next one finds it by its claim.
///
/// Its workers stop while more urgent runs need the machine (Precedence). One that is asked to end
/// is stopped no more, and one whose daemon dies while it is stopped is continued by the system.
class LocalExecutor : public Executor {
public:
  /// @param workers     outlives this object
  /// @param capacity    workers that may run at once
  /// @param precedence  outlives this object
  LocalExecutor(WarmWorkers& workers, int capacity, Precedence& precedence);
  /// Kills what it has started and is still running, unless that was left to itself, and waits for
  /// its end. A worker of an earlier daemon is left to the next one: this one has only tried to
  /// serve, or has ended it before.
  ~LocalExecutor() override { end_thread(); }

  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  int capacity() const override { return capacity_; }
  void start(const WorkerLaunch& launch) override;
  void stop(const std::string& job_id, int attempt) override;
  void kill(const std::string& job_id, int attempt) override;
  /// Found is the worker that claims the folder of the job, when it is of this attempt and of the
  /// protocol of this program. Any other that claims the folder is killed.
  Adoption adopt(const WorkerLaunch& launch, bool wanted) override;
  /// Those that have claimed a folder.
  void let_workers_run() override;

private:
  using Key = std::pair<std::string, int>;  ///< job and attempt
  struct Led {
    std::unique_ptr<WorkerProcess> process;
    Precedence::Place place{};  ///< none once it was asked to end
  };

  void end_thread();
  void run();
  void post(std::function<void()> order);
  void hand_over(const WorkerLaunch& launch);
  void lead(const WorkerLaunch& launch, std::unique_ptr<WorkerProcess> process);
  void set_stopped(const Key& key, const std::optional<MoreUrgentRun>& stopped_for);
  void wait_for_something();
  void collect();

  WarmWorkers& warm_;
  const int capacity_;
  Precedence& precedence_;
  Calls calls_;
  storage::FileDescriptor wake_;  ///< eventfd
  std::mutex mutex_;
  std::deque<std::function<void()>> orders_;

  // Of the thread alone.
  bool stopping_ = false;
  bool leaves_workers_ = false;
  std::map<Key, Led> workers_;
  std::thread thread_;
};

}  // namespace dccast::jobs
