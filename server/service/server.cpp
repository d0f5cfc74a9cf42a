#include "server/service/server.hpp"

#include <fmt/format.h>
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
#include "server/service/call.hpp"
#include "server/service/refusals.hpp"

namespace dccast::service {

namespace {

constexpr const char* alive = "alive";

constexpr int read_ahead = 512 * 1024;  // [bytes]

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
    // What gRPC reads of a call ahead of its handler: uploads come no faster than they are written.
    {GRPC_ARG_HTTP2_BDP_PROBE, 0},
    {GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, read_ahead},
    // No more calls are open than a busy client needs: what waits beyond is the client's.
    {GRPC_ARG_MAX_CONCURRENT_STREAMS, 100}};
constexpr std::size_t memory_of_transports = 256'000'000;  // [bytes]

/// @return what hands sockets of the relay to gRPC
std::function<void(int)> hand_over(grpc::ServerBuilder& builder, Gate& gate) {
  auto credentials = grpc::experimental::LocalServerCredentials(UDS);
  credentials->SetAuthMetadataProcessor(proof_before_body(gate));
  auto acceptor = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      std::move(credentials));

  return [acceptor = std::shared_ptr(std::move(acceptor))](int socket) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = socket;
    acceptor->HandleNewConnection(&parameters);
  };
}

using grpc::experimental::InterceptionHookPoints;

grpc::Status readable_status(const std::string& method) {
  if (method_at(method) != nullptr)
    return make_status(
        {.reason = ErrorInfo::INVALID_REQUEST,
         .cause = fmt::format(
             "the request of {} cannot be read as the message that service.proto names", method),
         .remedy = "use a client made from it"});
  return make_status(
      {.reason = ErrorInfo::UNKNOWN_CALL, .cause = fmt::format("dccastd has no call {}", method)});
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

/// How much requests may hold that have not come whole. A user may upload as many files at once as
/// intake::Uploads takes, whatever strangers hold, who need a few hundred bytes.
constexpr relay::MemoryBounds memory_bounds{.all = 96'000'000,
                                            .of_user = 80'000'000,
                                            .of_strangers = 16'000'000,
                                            .of_machine = 8'000'000,
                                            .of_call = request_bytes + read_ahead};

}  // namespace

void log_grpc_as_debug() {
  gpr_set_log_function([](gpr_log_func_args* line) {
    log::debug("gRPC {}:{}: {}", line->file, line->line, line->message);
  });
}

PublicServer::PublicServer(Context& context, const relay::Listener& local,
                           std::optional<TlsListening> tls)
    : service_(context), context_(context) {
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  auto serve = hand_over(builder, context.gate);

  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(std::make_unique<UnreadableRequests>());
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  builder.RegisterService(&service_);

  builder.SetMaxReceiveMessageSize(request_bytes);
  // The limit of a message holds for its bytes on the wire: a few megabytes of gzip stand for
  // gigabytes, which gRPC would unpack before anything looks at them.
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE})
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
  for (const auto& [name, value] : channel_arguments) builder.AddChannelArgument(name, value);
  builder.SetResourceQuota(grpc::ResourceQuota("dccastd").Resize(memory_of_transports));

  const v1::DaemonConfig::Limits& limits = context.settings.limits();
  const relay::Bounds bounds{
      .connections = static_cast<std::size_t>(limits.maximum_connections()),
      .per_peer = static_cast<std::size_t>(limits.maximum_connections_per_peer()),
      .web_user_id = context.gate.web_user_id()};
  relay_.emplace(context.gate.peers(), std::move(serve), memory_bounds);
  relay_->add(local, bounds, std::nullopt);
  if (tls) relay_->add(tls->listener, bounds, tls->files);

  server_ = builder.BuildAndStart();
  if (!server_) throw std::runtime_error(fmt::format("gRPC cannot serve on {}", local.address()));
  relay_->start();
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
  relay_->stop_accepting();  // gRPC takes no connection once it ends
  server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(1));
  server_->Wait();
  relay_->close();
}

}  // namespace dccast::service
