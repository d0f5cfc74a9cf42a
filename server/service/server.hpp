#pragma once

#include <grpcpp/server.h>

#include <memory>
#include <string>

#include "server/jobs/scheduler.hpp"
#include "server/service/context.hpp"
#include "server/service/door.hpp"
#include "server/service/listening_socket.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

/// SimulationService, health and reflection, listening on TCP.
class PublicServer {
public:
  /// @param listen  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  PublicServer(Context& context, studies::Studies& studies, const std::string& listen);
  ~PublicServer();
  /// Host and port in use.
  const std::string& address() const { return socket_.address(); }
  /// Health says NOT_SERVING from now on.
  void announce_end();
  /// Ends all calls: those that end by themselves within a second do.
  void shut_down();

private:
  ListeningSocket socket_;
  SimulationService service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Door> door_;
};

}  // namespace dccast::service
