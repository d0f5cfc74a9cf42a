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
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

/// Receives the events of a run before its answer.
using OnEvent = std::function<void(v1::JobEvent&)>;

/// A request was not answered.
class WorkerDidNotAnswer : public std::runtime_error {
public:
  /// Why there is no answer.
  enum class Why {
    not_started,  ///< the program cannot be started, or not now
    died,         ///< the worker crashed on the request
    killed,       ///< another process killed it, or the system when memory ran out
    refused,      ///< it gives a reason why it cannot answer, or its answer cannot be read
    too_slow,     ///< past the deadline; it was killed
    too_large,    ///< it exceeded its memory limit; it was killed
    called_off,   ///< the caller no longer waits for the answer; it was killed
  };
  WorkerDidNotAnswer(Why why, const std::string& what) : std::runtime_error(what), why_(why) {}
  Why why() const { return why_; }

private:
  Why why_;
};

class WorkerProcess;

/// Limits of a request.
struct CallLimits {
  std::chrono::steady_clock::time_point deadline;
  std::function<bool()> called_off = [] { return false; };  ///< the caller no longer waits
  std::int64_t largest_bytes = 4'000'000'000;               ///< memory of the worker [bytes]
  /// Registers the run with Precedence, which may stop it; absent: it is never stopped.
  std::function<Precedence::Registration(const WorkerProcess& worker)> enter{};
};

/// The folder with the files of a request: of a job whose frames it reads, of a case that comes
/// with files, or of the table that it writes. Empty: it has none. A worker reaches that of its
/// first request alone.
std::string folder_of(const v1::WorkerRequest& request);

/// A process of the worker program. It answers one request after another, or is handed the run of a
/// job; worker.proto describes the messages. A mesh or a result file that crashes it, or keeps it
/// busy forever, costs one answer but not the daemon. The system kills it when the thread that
/// started it ends, until it has claimed the folder of a job.
class WorkerProcess {
public:
  /// Starts a worker. @throws WorkerDidNotAnswer
  explicit WorkerProcess(const std::filesystem::path& program);
  /// Adopts a worker that an earlier daemon has started. @param handle  see open_process()
  WorkerProcess(pid_t process, storage::FileDescriptor handle)
      : handle_(std::move(handle)), id_(process) {}
  /// A process has one owner.
  WorkerProcess(const WorkerProcess&) = delete;
  /// Kills the process, unless leave() was called or an earlier daemon started it.
  ~WorkerProcess();

  /// Sends a request and waits for its answer.
  /// @throws WorkerDidNotAnswer  except for `refused`, the worker must not be asked again
  v1::WorkerAnswer ask(const v1::WorkerRequest& request, const CallLimits& limits,
                       const OnEvent& on_event);
  /// Sends the last request, a job, whose outcome will be in its folder. A worker that cannot
  /// receive it has ended: see exit().
  void hand_over(const v1::SolveCase& job);
  /// Leaves the process running when this object is destroyed.
  void leave() { process_ = 0; }
  /// Sends a signal; has no effect once the process has ended.
  void signal(int number) const;
  /// Stops the process (SIGSTOP) or continues it; may be called from any thread. Does nothing on a
  /// system without pidfds, because a process id may be reused.
  void set_stopped(bool stopped) const;

  /// Whether it is idle and still running.
  bool is_idle() const;
  /// Answers given so far, the folder of their files (see folder_of()), and memory in use [bytes].
  int answers() const { return answers_; }
  const std::string& folder() const { return folder_; }
  std::int64_t resident_bytes() const;
  /// Processor time that it has used [s]; nothing: it has ended. May be called from any thread.
  std::optional<double> processor_s() const { return jobs::processor_s(id_); }
  /// Its exit; nothing while it runs.
  std::optional<WorkerExit> exit();
  /// pidfd; -1 on a system without pidfds.
  int handle() const { return handle_.get(); }

private:
  /// Waits for an event of the socket. @throws WorkerDidNotAnswer  at the deadline or on
  /// cancellation
  void wait_until(short events, const CallLimits& limits) const;
  /// Sends a message with its length before it.
  void send(const google::protobuf::MessageLite& message, const CallLimits& limits);
  /// Receives one message. @throws WorkerDidNotAnswer
  v1::WorkerAnswer receive(const CallLimits& limits);
  /// Receives what has arrived into the buffer.
  void receive_more(const CallLimits& limits);
  /// @throws WorkerDidNotAnswer  with the way in which the process has ended
  [[noreturn]] void report_death();

  std::string name_;
  storage::FileDescriptor socket_;
  storage::FileDescriptor handle_;
  pid_t id_ = 0;          ///< also after its end
  pid_t process_ = 0;     ///< 0: not our child, or collected
  std::string received_;  ///< bytes of an incomplete message
  int answers_ = 0;
  std::string folder_;
};

}  // namespace dccast::jobs
