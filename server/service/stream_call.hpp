#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "server/service/call.hpp"

namespace dccast::service {

/// What a stream keeps of its call for its turn in a lane, when its context may be gone already.
class StreamCall {
public:
  /// @param users  outlives this object
  StreamCall(grpc::CallbackServerContext& context, LocalUsers& users);
  /// @param cancelled  of the stream itself
  Call call(std::function<bool()> cancelled) const;

private:
  std::string peer_;
  std::chrono::system_clock::time_point deadline_;
  LocalUsers* users_;
};

}  // namespace dccast::service
