#pragma once

#include <grpcpp/support/status.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "proto/refusal/refusal.hpp"

namespace dccast::client {

/// Exit codes of every program of the project.
enum class ExitCode {
  done = 0,
  invalid = 2,       ///< usage error, or a case with faults; with --strict also findings
  solve_failed = 3,  ///< the job did not succeed; with --strict also findings
  unreachable = 4,   ///< the server does not answer, or refuses
  not_found = 5,     ///< does not exist, or not allowed
  output_lost = 7,   ///< standard output or a file could not be written, e.g. on a full disk
  wrong_state = 6,   ///< not possible in the present state of the object
  interrupted = 130  ///< by SIGINT (Ctrl-C) or SIGTERM
};

/// A command failed: message for the user and exit code.
class CommandFailed : public std::runtime_error {
public:
  /// @param message  one sentence, with the remedy where there is one
  /// @param status  of the call that failed, if one did
  CommandFailed(ExitCode code, const std::string& message, grpc::Status status = {})
      : std::runtime_error(message), code_(code), status_(std::move(status)) {}
  /// Exit code of the program.
  ExitCode code() const { return code_; }
  /// OK: no call failed.
  const grpc::Status& status() const { return status_; }

private:
  ExitCode code_;
  grpc::Status status_;
};

/// For what a user gave and cannot be used: throw invalid("...").
inline CommandFailed invalid(const std::string& message) {
  return {ExitCode::invalid, message};
}

/// What hinders a connection: one sentence, and one remedy. Empty: nothing was found.
struct Diagnosis {
  /// Each one sentence; empty where nothing is wrong.
  std::string cause, remedy;
  bool sound() const { return cause.empty(); }
};

/// Converts the status of a call to a failure, with the remedy. `server` is the address for the
/// message.
CommandFailed failure_of(const grpc::Status& status, const std::string& server);

/// Why a call failed, in one line: the message of the daemon, or a summary instead of gRPC's report
/// of its connection attempts.
std::string reason_of(const grpc::Status& status);

/// Why the daemon refused a call. Empty where the status is not from it, but from gRPC.
std::optional<refusal::Facts> refusal_of(const grpc::Status& status);
/// Whether the daemon refused a call for this reason.
bool is_refused(const grpc::Status& status, refusal::Reason reason);

/// Throws `failure_of` unless the status is OK.
void check(const grpc::Status& status, const std::string& server);

}  // namespace dccast::client
