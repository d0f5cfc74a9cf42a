#pragma once

#include <grpcpp/server.h>

#include <filesystem>
#include <memory>
#include <string>

#include "server/jobs/scheduler.hpp"
#include "server/service/context.hpp"
#include "server/service/door.hpp"
#include "server/service/listening_socket.hpp"
#include "server/service/simulation_service.hpp"
#include "server/service/worker_link.hpp"

namespace dccast::service {

/// Where workers find the daemon, and every daemon after it: a Unix socket in the data directory,
/// the owner's alone as the directory is.
class LinkAddress {
public:
  explicit LinkAddress(const std::filesystem::path& data_directory);
  LinkAddress(const LinkAddress&) = delete;
  ~LinkAddress();
  std::string grpc_address() const { return "unix:" + socket_.string(); }
  /// A socket that listens there. @throws std::system_error
  storage::FileDescriptor listen() const;

private:
  std::filesystem::path socket_;
};

/// The worker link, listening. Behind a Door too: gRPC 1.51 ends a listener of its own forever
/// when a connection comes at a moment without a free descriptor, and no worker could call any
/// more.
class LinkServer {
public:
  /// @throws std::runtime_error  it cannot listen there
  LinkServer(jobs::Scheduler& scheduler, const LinkAddress& address);
  ~LinkServer();

private:
  storage::FileDescriptor listening_;
  WorkerLink link_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Door> door_;
};

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
