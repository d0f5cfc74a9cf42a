#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "dccast/v1/worker.pb.h"
#include "server/jobs/executors/precedence.hpp"

namespace dccast::jobs {

/// One start of a worker.
struct WorkerLaunch {
  std::string job_id;
  int attempt = 0;  ///< identifies this start together with the job's id
  std::filesystem::path folder{};
  v1::SolveCase order{};  ///< handed to the process; empty in adopt()
  Urgency urgency = Urgency::batch;
  double estimated_s = 0.0;  ///< solving time [s]; 0: not known
};

/// The end of a worker's process.
struct WorkerExit {
  std::string how;            ///< "exit code 1", "signal 9 (Killed)"
  std::optional<int> code{};  ///< nothing after a signal, or if it is not known
  bool of_machine = false;    ///< its machine was lost or withdrawn: no fault of the job
  bool cancelled = false;     ///< someone cancelled it beside dccast, as an administrator of Slurm
};

/// State of a worker that an earlier daemon started.
enum class Adoption {
  found,  ///< it runs or waits for a machine; this executor supervises it from now on
  gone,   ///< no process of it is left that could write into the folder of its job
};

/// Starts workers and reports when they end. What a worker does is recorded in the folder of its
/// job; the scheduler decides the outcome of the job. Functions may be called from any thread and
/// do not block.
class Executor {
public:
  /// Reports of the executor, called from its thread.
  struct Calls {
    /// The executor lacks a resource (descriptors, memory, the program): no fault of the job.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> not_started;
    std::function<void(const std::string& job_id, int attempt, const WorkerExit& exit)> ended;
    /// The worker has no machine yet, or its machine cannot be reached, so that no heartbeat is
    /// expected. Called repeatedly while that lasts, then once with an empty `why`.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> waits;
    /// The worker is stopped for a more urgent run. No heartbeat is expected until the next call
    /// with an empty `why`.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> stopped;
  };
  /// Executors are used through this interface alone.
  virtual ~Executor() = default;
  /// To be called before the first start.
  virtual void set_calls(Calls calls) = 0;
  /// Number of workers that may run at once.
  virtual int capacity() const = 0;
  /// Starts a worker; `ended` or `not_started` follows. @throws std::exception  it cannot be tried
  virtual void start(const WorkerLaunch& launch) = 0;
  /// Requests a worker to stop at a checkpoint (SIGTERM). Does nothing if it has ended.
  virtual void stop(const std::string& job_id, int attempt) = 0;
  /// Kills a worker; `ended` follows. Does nothing if it has ended.
  virtual void kill(const std::string& job_id, int attempt) = 0;
  /// Looks for a worker of an earlier daemon, before the first start. The call may take long, but
  /// must not wait for a callback. A worker that is found can be killed, and `ended` reports its
  /// end.
  /// @param wanted  false: any worker in the folder is killed, and the result is `gone`. A worker
  ///                that cannot be supervised is killed in either case.
  virtual Adoption adopt(const WorkerLaunch& launch, bool wanted) = 0;
  /// Announces the last adopt(): other workers in the folders of jobs may be killed from now on.
  virtual void end_adoption() {}
  /// Why no worker can be started for now, with the remedy; empty: it can.
  virtual std::string lacks() const { return {}; }
  /// Leaves running workers to the next daemon. No callback follows.
  virtual void let_workers_run() {}
};

}  // namespace dccast::jobs
