#include "server/service/server.hpp"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "server/service/grpc_trouble.hpp"

namespace dccast::service {

namespace {

/// Clients may ping as often as every 10 s, also between calls; without this gRPC answers them with
/// "too many pings" and hangs up.
void permit_pings(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000);
}

/// A connection that is silent from the start, or falls silent, is closed: a client that is alive
/// reconnects without noticing.
void end_idle_connections(grpc::ServerBuilder& builder) {
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 10000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 600000);
}

/// Hands accepted connections to gRPC, see Door.
std::function<void(int)> hand_over(
    std::shared_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor) {
  return [acceptor = std::move(acceptor)](int connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection;
    acceptor->HandleNewConnection(&parameters);
  };
}

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors() {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> all;
  all.push_back(std::make_unique<UnreadableRequests>());
  return all;
}

}  // namespace

PublicServer::PublicServer(Context& context, studies::Studies& studies, const std::string& listen)
    : socket_(listen), service_(context, studies, socket_.address()) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  builder.experimental().SetInterceptorCreators(interceptors());
  builder.RegisterService(&service_);
  builder.SetMaxReceiveMessageSize(static_cast<int>(context.maximum_message_bytes));
  permit_pings(builder);
  end_idle_connections(builder);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot serve on " + socket_.address());
  door_ = std::make_unique<Door>(socket_.descriptor(), context.maximum_connections,
                                 hand_over(std::move(acceptor)));
}

PublicServer::~PublicServer() {
  shut_down();
}

void PublicServer::announce_end() {
  server_->GetHealthCheckService()->SetServingStatus(false);
}

void PublicServer::shut_down() {
  door_.reset();  // gRPC takes no connection once it ends
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  server_->Wait();
}

}  // namespace dccast::service
