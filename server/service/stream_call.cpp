#include "server/service/stream_call.hpp"

#include <grpcpp/server_context.h>

#include <utility>

namespace dccast::service {

StreamCall::StreamCall(grpc::CallbackServerContext& context, LocalUsers& users)
    : peer_(context.peer()), deadline_(context.deadline()), users_(&users) {}

Call StreamCall::call(std::function<bool()> cancelled) const {
  return {.caller = users_->name_of(peer_),
          .role = Role::admin,
          .deadline = deadline_,
          .cancelled = std::move(cancelled)};
}

}  // namespace dccast::service
