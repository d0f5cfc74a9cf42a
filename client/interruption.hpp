#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/client_context.h>

#include "client/failure.hpp"

namespace dccast::client {

/// The command was interrupted; the message says what became of what it was doing.
class Interrupted : public CommandFailed {
public:
  explicit Interrupted(const std::string& rest)
      : CommandFailed(ExitCode::interrupted, "interrupted" + (rest.empty() ? "" : "; " + rest)) {}
};

/// A request to leave the command. It comes from another thread than the command's, which is told by its calls
/// ending early: so it leaves by its own way, with files closed and lines ended.
class Interruption {
public:
  /// Ends the call that is under way, and every later one.
  void come();
  bool came() const;
  /// Sleeps so long. Throws Interrupted.
  void sleep(std::chrono::milliseconds time);

  /// While it lives the interruption cancels this call. One at a time.
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

/// Takes SIGINT and SIGTERM from now on, in a thread of its own; call it before there are others. A
/// command that has not left a second after the first signal, or when another one comes, is ended.
void interrupt_by_signals(std::shared_ptr<Interruption> interruption);

}  // namespace dccast::client
