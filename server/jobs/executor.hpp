#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "server/jobs/process.hpp"

namespace dccast::jobs {

/// One start of a worker.
struct WorkerLaunch {
  std::string job_id;
  int attempt = 0;    ///< together with the job's id it names this start
  std::string token;  ///< what the worker proves itself with on the link
  std::filesystem::path folder;
};

/// Starts workers somewhere and tells when they end. Nothing else: what a worker does goes over the
/// worker link, and what becomes of its job is the scheduler's. A second executor starts workers on
/// other machines. Calls come from any thread and do not wait.
class Executor {
public:
  /// Both are called from the executor's thread and may take their time.
  struct Calls {
    std::function<void(const std::string& job_id, int attempt, ProcessIdentity)> started;
    /// @param how  "exit code 1", "signal 9 (Killed)", or why it could not be started
    std::function<void(const std::string& job_id, int attempt, const std::string& how)> ended;
  };
  virtual ~Executor() = default;
  /// Before the first start.
  virtual void set_calls(Calls calls) = 0;
  virtual void start(const WorkerLaunch& launch) = 0;
  /// Ends a worker at once. Nothing happens when it is gone; `ended` follows otherwise.
  virtual void kill(const std::string& job_id, int attempt) = 0;
};

}  // namespace dccast::jobs
