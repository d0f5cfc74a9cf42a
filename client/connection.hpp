#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/client_context.h>

#include "client/failure.hpp"
#include "dccast/v1/service.grpc.pb.h"

namespace dccast::client {

using Stub = v1::SimulationService::StubInterface;

/// A daemon to talk to. The connection is made by the first call.
class Connection {
public:
  explicit Connection(const std::string& server);
  /// For tests: a stub of any kind.
  Connection(std::string server, std::unique_ptr<Stub> stub)
      : server_(std::move(server)), stub_(std::move(stub)) {}

  Stub& stub() { return *stub_; }
  const std::string& server() const { return server_; }

  /// One unary call with a deadline. Throws CommandFailed for any status but OK.
  template <typename Request, typename Response>
  Response call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                const Request& request) {
    Response response;
    check(try_call(method, request, response), server_);
    return response;
  }

  /// The same, the status returned.
  template <typename Request, typename Response>
  grpc::Status try_call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                     Response*),
                        const Request& request, Response& response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    return (stub_.get()->*method)(&context, request, &response);
  }

private:
  static constexpr std::chrono::seconds deadline{60};  // also for a case with large attachments
  std::string server_;
  std::unique_ptr<Stub> stub_;
};

}  // namespace dccast::client
