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
  int attempt = 0;  ///< together with the job's id it names this start
  std::filesystem::path folder{};
  v1::SolveCase order{};  ///< handed to the process; empty in adopt()
  Urgency urgency = Urgency::batch;
  double estimated_s = 0.0;  ///< solving time [s]; 0: not known
};

/// The end of a worker's process.
struct WorkerExit {
  std::string how;            ///< "exit code 1", "signal 9 (Killed)"
  std::optional<int> code{};  ///< nothing after a signal, or where it is not known
  bool of_machine = false;    ///< its machine was lost or taken away: no fault of the job
};

/// What has become of a worker that an earlier daemon started.
enum class Adoption {
  found,  ///< it runs or still waits for a machine; this executor leads it from now on
  gone,   ///< nothing of it is left that could write into the folder of its job
};

/// Starts workers somewhere and reports when they end. Nothing else: what a worker does stands in
/// the folder of its job, and the outcome of the job is the scheduler's. A second executor starts
/// workers on other machines. Calls come from any thread and do not wait.
class Executor {
public:
  /// All are called from the executor's thread.
  struct Calls {
    /// The executor lacks a resource (descriptors, memory, the program): no fault of the job.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> not_started;
    std::function<void(const std::string& job_id, int attempt, const WorkerExit& exit)> ended;
    /// It has no machine yet, or none that can be asked for it, and gives no signs of life; called
    /// now and then as long as that is so, and once with an empty `why` when it has begun.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> waits;
    /// It is stopped for a more urgent run and gives no signs of life until it is called with an
    /// empty `why`.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> stopped;
  };
  virtual ~Executor() = default;
  /// Before the first start.
  virtual void set_calls(Calls calls) = 0;
  /// Workers that may run at once.
  virtual int capacity() const = 0;
  /// `ended` or `not_started` follows. @throws std::exception  it cannot even be tried
  virtual void start(const WorkerLaunch& launch) = 0;
  /// Requests a worker to stop at a checkpoint (SIGTERM). Nothing happens when it is gone.
  virtual void stop(const std::string& job_id, int attempt) = 0;
  /// Ends a worker at once. Nothing happens when it is gone; `ended` follows otherwise.
  virtual void kill(const std::string& job_id, int attempt) = 0;
  /// Looks for a worker that an earlier daemon started, before the first start; may take its time,
  /// but must not wait for a call back. A worker that is found is ended by kill(), and `ended`
  /// reports its end.
  /// @param wanted  false: whatever works in the folder is ended here, and the answer is gone; so
  /// is
  ///                what the executor cannot lead on with
  virtual Adoption adopt(const WorkerLaunch& launch, bool wanted) = 0;
  /// No adopt() comes any more: whatever else works in the folders of jobs may be ended.
  virtual void end_adoption() {}
  /// Leaves workers at their jobs to the next daemon. No call back comes any more.
  virtual void let_workers_run() {}
};

}  // namespace dccast::jobs
