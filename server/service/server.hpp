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

/// Forwards gRPC's log lines to our log at level debug: they name gRPC's sources and help no user.
void log_grpc_as_debug();

/// Address for users of other machines.
struct TlsListening {
  /// Already listening; accepted from once the server runs.
  const relay::Listener& listener;
  relay::TlsFiles files;
};

/// SimulationService, health and reflection, at a Unix socket for local users and over TLS for
/// others. Health by name: "alive" is SERVING while calls are answered; "ready" and the service's
/// own name while jobs are started, so neither while the queue is held nor once the daemon is
/// ending; the empty name until the daemon is ending.
class PublicServer {
public:
  /// @param local  a Unix socket, of local users
  /// @param tls    empty: only local users can call
  /// @throws std::runtime_error  gRPC refuses, or the TLS files cannot be used
  PublicServer(Context& context, const relay::Listener& local, std::optional<TlsListening> tls);
  /// Stops accepting, ends streams, and waits for calls that are under way.
  ~PublicServer();
  /// Sets health to NOT_SERVING, except for "alive".
  void announce_end();
  /// Ends all calls; gives them one second to finish by themselves.
  void shut_down();

private:
  SimulationService service_;
  /// The thread: sets the statuses of the health service.
  void report_health(const std::stop_token& stop);

  Context& context_;
  std::unique_ptr<grpc::Server> server_;
  std::optional<relay::Relay> relay_;
  std::jthread health_;
};

}  // namespace dccast::service
