#pragma once

#include <grpcpp/support/server_interceptor.h>

namespace dccast::service {

/// Sends what gRPC logs to our log, as debug: its lines name its own sources and help nobody else.
void log_grpc_as_debug();

/// A request whose bytes are no message of its call never reaches its handler: gRPC answers
/// UNIMPLEMENTED without a word, as it does to a call that is not there. This makes the first
/// INVALID_ARGUMENT, and gives both a text.
class UnreadableRequests final : public grpc::experimental::ServerInterceptorFactoryInterface {
public:
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* call) override;
};

}  // namespace dccast::service
