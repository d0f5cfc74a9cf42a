#pragma once

#include <grpcpp/server.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/relay/relay.hpp"
#include "server/service/context.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

/// Sends what gRPC logs to our log, as debug: its lines name its own sources and help no user.
void log_grpc_as_debug();

/// Where users of other machines call.
struct TlsListening {
  const relay::Listener& listener;
  std::size_t connections_per_peer = SIZE_MAX;
  relay::TlsFiles files;
};

/// SimulationService, health and reflection: for local users at a Unix socket, for others over TLS.
/// The health of "alive" is SERVING while calls are answered; that of "ready" and of the service
/// while jobs are started, too: not while the queue is held, nor once the daemon is about to end.
/// The empty name is that of the daemon until it is about to end.
class PublicServer {
public:
  /// @param local  a Unix socket, of local users @param tls  nothing: local users alone
  /// @throws std::runtime_error  gRPC refuses, or the files of TLS cannot be used
  PublicServer(Context& context, const relay::Listener& local, std::optional<TlsListening> tls);
  ~PublicServer();
  /// Health is NOT_SERVING from now on, but for "alive".
  void announce_end();
  /// Ends all calls: those that end by themselves within a second do.
  void shut_down();

private:
  SimulationService service_;
  void report_health(const std::stop_token& stop);

  Context& context_;
  std::unique_ptr<grpc::Server> server_;
  std::optional<relay::Relay> relay_;
  std::jthread health_;
};

}  // namespace dccast::service
