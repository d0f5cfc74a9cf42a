#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "server/jobs/checker.hpp"
#include "server/service/local_users.hpp"

namespace grpc {
class CallbackServerContext;
}

namespace dccast::service {

/// What a caller may do.
enum class Role {
  admin,  ///< everything, with everybody's jobs; whoever reaches the loopback address
};

/// Who calls and how long they wait.
struct Call {
  std::string caller;  ///< name of the local user; empty when it cannot be learned
  Role role = Role::admin;
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  std::function<bool()> cancelled = [] { return false; };
};

/// @param context  of a call that has not been answered yet; must outlive the Call
Call call_of(grpc::CallbackServerContext& context, LocalUsers& users);

/// The status of a call that nobody waits for any more; nothing while its caller does.
std::optional<grpc::Status> no_longer_wanted(const Call& call);

/// As long as the caller waits, and no longer than `most`.
jobs::Patience patience(const Call& call, std::chrono::milliseconds most);

}  // namespace dccast::service
