#include "server/service/call.hpp"

#include <grpcpp/server_context.h>

#include <algorithm>
#include <utility>

namespace dccast::service {

CallOrigin::CallOrigin(const grpc::CallbackServerContext& context, LocalUsers& users)
    : peer_(context.peer()), deadline_(context.deadline()), users_(&users) {}

Call CallOrigin::call(std::function<bool()> cancelled) const {
  return {.caller = users_->name_of(peer_),
          .role = Role::admin,
          .deadline = deadline_,
          .cancelled = std::move(cancelled)};
}

std::optional<grpc::Status> no_longer_wanted(const Call& call) {
  if (call.cancelled()) return grpc::Status(grpc::StatusCode::CANCELLED, "the caller has left");
  if (std::chrono::system_clock::now() < call.deadline) return std::nullopt;
  return grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED,
                      "the call waited until its deadline; try again");
}

jobs::CallLimits waiting_time(const Call& call, std::chrono::milliseconds most) {
  const auto left = call.deadline - std::chrono::system_clock::now();
  return {
      .deadline = std::chrono::steady_clock::now() + std::min<std::chrono::nanoseconds>(left, most),
      .called_off = call.cancelled};
}

}  // namespace dccast::service
