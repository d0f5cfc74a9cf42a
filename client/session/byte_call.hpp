#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace google::protobuf {
class MethodDescriptor;
}

namespace dccast::client {

/// A method of the service by its name, as in service.proto. Null: there is none.
const google::protobuf::MethodDescriptor* find_method(const std::string& name);

/// A call of any method, whose messages are bytes. It holds no thread. What it calls back comes
/// from threads of gRPC, one after the other.
struct ByteCall {
  const google::protobuf::MethodDescriptor& method;
  std::vector<std::string> requests;  ///< one, but of a method that takes a stream
  std::chrono::system_clock::time_point deadline;
  /// Receives each response. The next one is read once `next` was called, with false to cancel.
  std::function<void(std::string response, std::function<void(bool)> next)> received;
  /// Receives the status at the end, once.
  std::function<void(const grpc::Status&)> ended;
};

/// Begins a call. @return cancels it, from any thread and at any time
std::function<void()> begin_call(const std::shared_ptr<grpc::Channel>& channel, ByteCall call);

/// Makes a call with one request and one response, and waits for it.
grpc::Status call_bytes(const std::shared_ptr<grpc::Channel>& channel,
                        const google::protobuf::MethodDescriptor& method, std::string request,
                        std::chrono::system_clock::time_point deadline, std::string& response);

}  // namespace dccast::client
