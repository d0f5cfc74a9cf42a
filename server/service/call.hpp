#pragma once

#include <grpcpp/support/status.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "server/jobs/worker_process.hpp"
#include "server/service/local_users.hpp"

namespace grpc {
class CallbackServerContext;
}

namespace dccast::service {

/// What a caller may do.
enum class Role {
  admin,  ///< everything, with everybody's jobs; any user who reaches the loopback address
};

/// Who calls and how long they wait.
struct Call {
  std::string caller;  ///< name of the local user; empty when it cannot be found
  Role role = Role::admin;
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  std::function<bool()> cancelled = [] { return false; };
};

/// What is kept of a call for its turn in a lane, when its context may be gone already.
class CallOrigin {
public:
  /// @param users  outlives this object
  CallOrigin(const grpc::CallbackServerContext& context, LocalUsers& users);
  /// Looks the caller up: for a thread that may wait.
  Call call(std::function<bool()> cancelled) const;

private:
  std::string peer_;
  std::chrono::system_clock::time_point deadline_;
  LocalUsers* users_;
};

/// The status of a call that is cancelled or past its deadline; nothing while its caller waits.
std::optional<grpc::Status> no_longer_wanted(const Call& call);

/// As long as the caller waits, and no longer than `most`.
jobs::CallLimits waiting_time(const Call& call, std::chrono::milliseconds most);

}  // namespace dccast::service
