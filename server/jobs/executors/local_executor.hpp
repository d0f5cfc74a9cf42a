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

/// Runs jobs in worker processes on the daemon's machine, and supervises those of the last daemon.
///
/// A worker dies with its daemon until it has claimed the folder of its job (FolderClaim). After
/// that it outlives the daemon, and the next daemon finds it by its claim.
///
/// Workers are stopped while more urgent runs need the machine (Precedence), once they have claimed
/// their folder: then they have the timer that continues them. A worker that is requested to end is
/// no longer stopped. If the daemon dies, its stopped workers are continued by the system.
class LocalExecutor : public Executor {
public:
  /// @param workers     outlives this object
  /// @param capacity    number of workers that may run at once
  /// @param precedence  outlives this object
  LocalExecutor(WarmWorkers& workers, int capacity, Precedence& precedence);
  /// Kills the workers it has started, unless let_workers_run() was called, and waits for their
  /// end. Workers of an earlier daemon are left to the next one.
  ~LocalExecutor() override { end_thread(); }

  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  /// Workers that may run at once.
  int capacity() const override { return capacity_; }
  /// Starts a worker; how it went is reported by the calls.
  void start(const WorkerLaunch& launch) override;
  /// Requests a stop at a checkpoint, or kills at once.
  void stop(const std::string& job_id, int attempt) override;
  void kill(const std::string& job_id, int attempt) override;
  /// Adopts the worker that claims the folder of the job, if it belongs to this attempt and uses
  /// the protocol of this program. Any other worker that claims the folder is killed.
  Adoption adopt(const WorkerLaunch& launch, bool wanted) override;
  /// Only workers that have claimed a folder survive.
  void let_workers_run() override;

private:
  using Key = std::pair<std::string, int>;  ///< job and attempt
  struct Supervised {
    std::unique_ptr<WorkerProcess> process;
    WorkerLaunch launch;
    std::int64_t claimed_before_ns = 0;       ///< time of the last claim when it got its job
    bool awaits_claim = false;                ///< it can neither stop others yet nor be stopped
    Precedence::Registration registration{};  ///< between its claim and the request to end
  };

  /// Ends the thread; workers are killed or left, see let_workers_run().
  void end_thread();
  /// The thread: carries out orders and collects workers that have ended.
  void run();
  /// Has the thread carry out an order.
  void post(std::function<void()> order);
  /// Hands a job to a warm worker.
  void hand_over(const WorkerLaunch& launch);
  /// Lets a worker that has claimed its folder stop others, and be stopped.
  void enter_precedence(const Key& key, Supervised& worker);
  /// Looks for claims of the workers that have not claimed their folder yet.
  void look_for_claims();
  /// Stops a worker's process, or lets it continue. @param stopped_for  empty: continue
  void set_stopped(const Key& key, const std::optional<MoreUrgentRun>& stopped_for);
  /// Waits for an order or for the end of a worker.
  void wait_for_event();
  /// Reports the workers that have ended.
  void collect();

  WarmWorkers& warm_;
  const int capacity_;
  Precedence& precedence_;
  Calls calls_;
  storage::FileDescriptor wake_;  ///< eventfd
  std::mutex mutex_;
  std::deque<std::function<void()>> orders_;

  // Used only by the thread.
  bool stopping_ = false;
  bool leaves_workers_ = false;
  std::map<Key, Supervised> workers_;
  std::thread thread_;
};

}  // namespace dccast::jobs
