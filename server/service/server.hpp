#pragma once

#include <grpcpp/server.h>

#include <memory>
#include <string>

#include "server/service/context.hpp"
#include "server/service/listener.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

/// Sends what gRPC logs to our log, as debug: its lines name its own sources and help no user.
void log_grpc_as_debug();

/// SimulationService, health and reflection, listening on TCP.
class PublicServer {
public:
  /// @param listen  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  PublicServer(Context& context, const std::string& listen);
  ~PublicServer();
  /// Host and port in use.
  const std::string& address() const { return listener_.address(); }
  /// Health is NOT_SERVING from now on.
  void announce_end();
  /// Ends all calls: those that end by themselves within a second do.
  void shut_down();

private:
  Listener listener_;
  SimulationService service_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace dccast::service
