#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/storage/file.hpp"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/executors/executor.hpp"
#include "server/jobs/executors/precedence.hpp"

namespace dccast::jobs {

/// What the answer to a run has before its end.
using OnEvent = std::function<void(v1::JobEvent&)>;

/// A request got no answer.
class WorkerDidNotAnswer : public std::runtime_error {
public:
  enum class Why {
    not_started,  ///< the program cannot be started, or not now
    died,         ///< the request brought it down
    killed,       ///< somebody killed it, e.g. the system when memory ran out
    refused,      ///< it gives a reason why it cannot answer, or its answer cannot be read
    too_slow,     ///< past the deadline; it was killed
    too_large,    ///< it took more memory than it may; it was killed
    called_off,   ///< no one waits for the answer any more; it was killed
  };
  WorkerDidNotAnswer(Why why, const std::string& what) : std::runtime_error(what), why_(why) {}
  Why why() const { return why_; }

private:
  Why why_;
};

class WorkerProcess;

/// What an answer may take and who still wants it.
struct CallLimits {
  std::chrono::steady_clock::time_point deadline;
  std::function<bool()> called_off = [] { return false; };
  std::int64_t largest_bytes = 4'000'000'000;  ///< of memory
  /// Takes the place of the run among the others, which may stop it; absent: nothing stops it.
  std::function<Precedence::Place(const WorkerProcess& worker)> enter{};
};

/// A process of the worker program. It answers request after request, or is handed the run of a job
/// and left to it; worker.proto has what is sent. A mesh or a result file that brings it down or
/// keeps it busy forever costs one answer, not the daemon. The system kills it when the thread that
/// started it ends, until it has claimed the folder of a job.
class WorkerProcess {
public:
  /// Starts one. @param scratch  where it may write files for answers; empty: nowhere
  /// @throws WorkerDidNotAnswer
  WorkerProcess(const std::filesystem::path& program, const std::filesystem::path& scratch);
  /// Leads on one that an earlier daemon has started. @param handle  see open_process()
  explicit WorkerProcess(storage::FileDescriptor handle) : handle_(std::move(handle)) {}
  WorkerProcess(const WorkerProcess&) = delete;
  /// Kills the process, unless it was left or started by an earlier daemon.
  ~WorkerProcess();

  /// @throws WorkerDidNotAnswer  save for `refused`, it must not be asked again then
  v1::WorkerAnswer ask(const v1::WorkerRequest& request, const CallLimits& limits,
                       const OnEvent& on_event);
  /// Its last request, whose outcome is in the folder of the job. One that cannot take it has
  /// ended: see exit().
  void hand_over(const v1::SolveCase& job);
  void leave() { process_ = 0; }
  void signal(int number) const;
  /// Stops the process (SIGSTOP) or continues it. From any thread. Does nothing on a system without
  /// pidfds: an id alone may be that of another process by then.
  void set_stopped(bool stopped) const;

  /// Whether nothing has happened to it while it waited.
  bool waits() const;
  int answers() const { return answers_; }
  std::int64_t resident_bytes() const;
  /// How it has ended; nothing while it runs.
  std::optional<WorkerExit> exit();
  /// pidfd; -1 where the system has none.
  int handle() const { return handle_.get(); }

private:
  void wait_until(short events, const CallLimits& limits) const;
  void send(const google::protobuf::MessageLite& message, const CallLimits& limits);
  v1::WorkerAnswer receive(const CallLimits& limits);
  void receive_more(const CallLimits& limits);
  [[noreturn]] void report_death();

  std::string name_;
  storage::FileDescriptor socket_;
  storage::FileDescriptor handle_;
  pid_t process_ = 0;     ///< 0: none of ours, or collected
  std::string received_;  ///< of messages that are not whole yet
  int answers_ = 0;
};

}  // namespace dccast::jobs
