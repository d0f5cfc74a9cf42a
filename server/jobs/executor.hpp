#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace dccast::jobs {

/// One start of a worker.
struct WorkerLaunch {
  std::string job_id;
  int attempt = 0;      ///< together with the job's id it names this start
  std::string token{};  ///< what the worker proves itself with on the link; empty in adopt()
  std::filesystem::path folder{};
};

/// What has become of a worker that an earlier daemon started.
enum class Adoption {
  found,  ///< it runs or still waits for a machine; this executor leads it from now on
  gone,   ///< nothing of it is left that could write into the folder of its job
};

/// Starts workers somewhere and tells when they end. Nothing else: what a worker does goes over the
/// worker link, and the outcome of its job is the scheduler's. A second executor starts workers on
/// other machines. Calls come from any thread and do not wait.
class Executor {
public:
  /// All are called from the executor's thread and may take their time.
  struct Calls {
    /// @param handle  the worker in the executor's own words, for adopt(); kept in the job store
    std::function<void(const std::string& job_id, int attempt, const std::string& handle)> started;
    /// The executor lacks a resource (descriptors, memory, the program): no fault of the job.
    std::function<void(const std::string& job_id, int attempt, const std::string& why)> not_started;
    /// @param how  "exit code 1", "signal 9 (Killed)"
    std::function<void(const std::string& job_id, int attempt, const std::string& how)> ended;
  };
  virtual ~Executor() = default;
  /// Before the first start.
  virtual void set_calls(Calls calls) = 0;
  /// Workers that may run at once.
  virtual int capacity() const = 0;
  /// `started` or `not_started` follows. @throws std::exception  it cannot even be tried
  virtual void start(const WorkerLaunch& launch) = 0;
  /// Ends a worker at once. Nothing happens when it is gone; `ended` follows otherwise.
  virtual void kill(const std::string& job_id, int attempt) = 0;
  /// Looks for a worker that an earlier daemon started, before the first start; may take its time,
  /// but must not wait for a call back. A worker that is found is ended by kill(), and `ended`
  /// tells of its end. What the executor cannot lead on with it ends here, and answers gone.
  /// @param handle  as `started` gave it; empty when the earlier daemon ended before: the job's id
  ///                and attempt still name the worker
  virtual Adoption adopt(const std::string& handle, const WorkerLaunch& launch) = 0;
};

}  // namespace dccast::jobs
