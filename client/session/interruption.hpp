#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/client_context.h>

#include "client/session/failure.hpp"

namespace dccast::client {

/// The command was interrupted; the message states what happened to its work.
class Interrupted : public CommandFailed {
public:
  explicit Interrupted(const std::string& rest)
      : CommandFailed(ExitCode::interrupted, "interrupted" + (rest.empty() ? "" : "; " + rest)) {}
};

/// A request to end the command, made by another thread. The command notices it because its calls
/// end early, and so leaves in an orderly way, with files closed and lines completed.
class Interruption {
public:
  /// Cancels the current call and every later one.
  void come();
  bool came() const;
  /// Sleeps for `time`. Throws Interrupted.
  void sleep(std::chrono::milliseconds time);

  /// During its lifetime an interruption cancels this call. Only one may exist at a time.
  class Call {
  public:
    Call(Interruption& interruption, grpc::ClientContext& context);
    Call(const Call&) = delete;
    ~Call();

  private:
    Interruption& interruption_;
  };

private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool came_ = false;
  grpc::ClientContext* call_ = nullptr;
};

/// Handles SIGINT and SIGTERM from now on in a thread of its own; must be called before other
/// threads start. A command that has not ended one second after the first signal, or at the second
/// signal, is terminated.
void interrupt_by_signals(std::shared_ptr<Interruption> interruption);

}  // namespace dccast::client
