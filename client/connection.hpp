#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/client_context.h>

#include "client/failure.hpp"
#include "client/interruption.hpp"
#include "dccast/v1/service.grpc.pb.h"

namespace dccast::client {

using Stub = v1::SimulationService::StubInterface;

/// A daemon to talk to. The connection is made by the first call.
class Connection {
public:
  explicit Connection(const std::string& server, std::shared_ptr<Interruption> interruption =
                                                     std::make_shared<Interruption>());

  Stub& stub() { return *stub_; }
  const std::string& server() const { return server_; }
  /// Whoever waits for this server, in a call or between two, must listen to it.
  Interruption& interruption() { return *interruption_; }

  /// One unary call with a deadline. Throws CommandFailed for any status but OK.
  template <typename Request, typename Response>
  Response call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                const Request& request) {
    Response response;
    check(try_call(method, request, response), server_);
    return response;
  }

  /// The same, the status returned. Throws Interrupted.
  template <typename Request, typename Response>
  grpc::Status try_call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                     Response*),
                        const Request& request, Response& response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    const Interruption::Call call(*interruption_, context);
    const grpc::Status status = (stub_.get()->*method)(&context, request, &response);
    if (!status.ok() && interruption_->came()) throw Interrupted("");
    return status;
  }

private:
  static constexpr std::chrono::seconds deadline{60};  // also for a case with large attachments
  std::string server_;
  std::unique_ptr<Stub> stub_;
  std::shared_ptr<Interruption> interruption_;
};

}  // namespace dccast::client
