#pragma once

#include <stdexcept>
#include <string>

#include <grpcpp/support/status.h>

#include "client/exit_code.hpp"

namespace dccast::client {

/// A command that cannot go on: what to tell the user, and the exit code.
class CommandFailed : public std::runtime_error {
public:
  CommandFailed(ExitCode code, const std::string& message)
      : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

private:
  ExitCode code_;
};

/// The failure that a call's status means, with the remedy. `server` is the address for the
/// message.
CommandFailed failure_of(const grpc::Status& status, const std::string& server);

/// Why a call failed, in one line for people: what the daemon said, or in place of gRPC's own
/// report of its attempts what it comes to.
std::string reason_of(const grpc::Status& status);

/// Throws `failure_of` unless the status is OK.
void check(const grpc::Status& status, const std::string& server);

}  // namespace dccast::client
