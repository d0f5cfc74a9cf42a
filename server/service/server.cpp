#include "server/service/server.hpp"

#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>
#include <grpcpp/support/server_interceptor.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/log.hpp"
#include "server/service/connection_watch.hpp"

namespace dccast::service {

namespace {

constexpr const char* alive = "alive";

/// Of all connections.
constexpr std::pair<const char*, int> channel_arguments[]{
    // Clients may ping as often as every 10 s, also between calls; without this gRPC answers them
    // with "too many pings" and hangs up.
    {GRPC_ARG_KEEPALIVE_TIME_MS, 20000},
    {GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000},
    {GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1},
    {GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5000},
    // A connection that is silent from the start, or falls silent, is closed: a client that is
    // alive reconnects without noticing.
    {GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 10000},
    {GRPC_ARG_MAX_CONNECTION_IDLE_MS, 600000},
    // No more calls are open than a busy client needs: what waits beyond is the client's.
    {GRPC_ARG_MAX_CONCURRENT_STREAMS, 100}};
constexpr std::size_t memory_of_transports = 256'000'000;  // [bytes]

// What a client sends before its first request, with some pings: preface, settings, window; with
// TLS its half of the handshake, too, without a certificate.
constexpr std::uint64_t greeting_bytes = 200;
constexpr std::uint64_t tls_greeting_bytes = 1200;

std::shared_ptr<grpc::ServerCredentials> tls_credentials(const TlsListening& tls, Gate& gate) {
  constexpr unsigned looked_at_every_s = 1;
  const bool asks = !tls.client_ca.empty();
  grpc::experimental::TlsServerCredentialsOptions options(
      std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
          tls.key, tls.certificate, tls.client_ca, looked_at_every_s));
  options.watch_identity_key_cert_pairs();
  if (asks) options.watch_root_certs();
  // One who shows no certificate may have a token; one who shows a wrong one is refused.
  options.set_cert_request_type(asks ? GRPC_SSL_REQUEST_CLIENT_CERTIFICATE_AND_VERIFY
                                     : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  auto credentials = grpc::experimental::TlsServerCredentials(options);
  credentials->SetAuthMetadataProcessor(proof_before_body(gate));
  return credentials;
}

/// @return what hands accepted connections to gRPC, see Listener
std::function<void(int)> hand_over(grpc::ServerBuilder& builder,
                                   std::shared_ptr<grpc::ServerCredentials> credentials) {
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      std::move(credentials));
  return [acceptor = std::shared_ptr(std::move(acceptor))](int connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection;
    acceptor->HandleNewConnection(&parameters);
  };
}

using grpc::experimental::InterceptionHookPoints;

grpc::Status readable_status(const std::string& method) {
  if (method_at(method) != nullptr)
    return {
        grpc::INVALID_ARGUMENT,
        "the request of " + method +
            " cannot be read as the message that service.proto names; use a client made from it"};
  return {grpc::UNIMPLEMENTED, "dccastd has no call " + method};
}

/// Lives as long as its call.
class Answer final : public grpc::experimental::Interceptor {
public:
  explicit Answer(std::string method) : method_(std::move(method)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      const grpc::Status status = batch->GetSendStatus();
      // No handler of ours answers so: each that refuses gives its reason.
      if (status.error_code() == grpc::UNIMPLEMENTED && status.error_message().empty())
        batch->ModifySendStatus(readable_status(method_));
    }
    batch->Proceed();
  }

private:
  const std::string method_;
};

/// A request whose bytes are no message of its call never reaches its handler: gRPC answers
/// UNIMPLEMENTED without a text, as it does to a call that is not there. This makes the first
/// INVALID_ARGUMENT, and gives both a text.
class UnreadableRequests final : public grpc::experimental::ServerInterceptorFactoryInterface {
public:
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* call) override {
    return new Answer(call->method());
  }
};

// Of requests that have not come whole, beside one of the largest [bytes].
constexpr std::size_t unfinished_beside_the_largest = 32'000'000;

}  // namespace

void log_grpc_as_debug() {
  gpr_set_log_function([](gpr_log_func_args* line) {
    log::debug("gRPC {}:{}: {}", line->file, line->line, line->message);
  });
}

PublicServer::PublicServer(Context& context, Listener& local, std::optional<TlsListening> tls)
    : local_(local), tls_(std::move(tls)), service_(context), context_(context) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  const auto admit = hand_over(builder, grpc::InsecureServerCredentials());
  const auto admit_over_tls =
      tls_ ? hand_over(builder, tls_credentials(*tls_, context.gate)) : nullptr;
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(std::make_unique<UnreadableRequests>());
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  builder.RegisterService(&service_);
  const double largest = context.settings.maximum_message_bytes();
  builder.SetMaxReceiveMessageSize(static_cast<int>(largest));
  // The limit of a message holds for its bytes on the wire: a few megabytes of gzip stand for
  // gigabytes, which gRPC would unpack before anything looks at them.
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE})
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
  for (const auto& [name, value] : channel_arguments) builder.AddChannelArgument(name, value);
  builder.SetResourceQuota(grpc::ResourceQuota("dccastd").Resize(memory_of_transports));
  bound_unfinished_requests(static_cast<std::size_t>(largest) + unfinished_beside_the_largest);
  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error("gRPC cannot serve on " + local_.address());
  const auto connections = static_cast<std::size_t>(context.settings.maximum_connections());
  local_.start({.connections = connections, .greeting_bytes = greeting_bytes}, admit);
  if (tls_)
    tls_->listener.start({.connections = connections,
                          .per_peer = tls_->connections_per_peer,
                          .greeting_bytes = tls_greeting_bytes,
                          .over_tls = true},
                         admit_over_tls);
  server_->GetHealthCheckService()->SetServingStatus(alive, true);
  health_ = std::jthread([this](const std::stop_token& stop) { report_health(stop); });
}

void PublicServer::report_health(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds between_looks{200};
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  do {
    const bool ready = context_.scheduler.held().empty();
    for (const char* name : {"ready", v1::SimulationService::service_full_name()})
      server_->GetHealthCheckService()->SetServingStatus(name, ready);
  } while (!never.wait_for(lock, stop, between_looks, [&] { return stop.stop_requested(); }));
}

PublicServer::~PublicServer() {
  shut_down();
}

void PublicServer::announce_end() {
  health_ = {};
  server_->GetHealthCheckService()->SetServingStatus(false);
  server_->GetHealthCheckService()->SetServingStatus(alive, true);
}

void PublicServer::shut_down() {
  health_ = {};
  local_.stop();  // gRPC takes no connection once it ends
  if (tls_) tls_->listener.stop();
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  server_->Wait();
}

}  // namespace dccast::service
