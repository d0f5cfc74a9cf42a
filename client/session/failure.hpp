#pragma once

#include <stdexcept>
#include <string>

#include <grpcpp/support/status.h>

#include "client/session/exit_code.hpp"

namespace dccast::client {

/// A command failed: message for the user and exit code.
class CommandFailed : public std::runtime_error {
public:
  CommandFailed(ExitCode code, const std::string& message)
      : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

private:
  ExitCode code_;
};

/// Converts the status of a call to a failure, with the remedy. `server` is the address for the
/// message.
CommandFailed failure_of(const grpc::Status& status, const std::string& server);

/// Why a call failed, in one line: the message of the daemon, or a summary instead of gRPC's report
/// of its connection attempts.
std::string reason_of(const grpc::Status& status);

/// Throws `failure_of` unless the status is OK.
void check(const grpc::Status& status, const std::string& server);

}  // namespace dccast::client
