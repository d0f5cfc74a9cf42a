#include "client/session/connection.hpp"

#include <iostream>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

namespace dccast::client {

Connection::Connection(const std::string& server, std::shared_ptr<Interruption> interruption)
    : server_(server), interruption_(std::move(interruption)) {
  grpc::ChannelArguments arguments;
  // Histories and frames of long runs exceed gRPC's default of 4 MiB.
  arguments.SetMaxReceiveMessageSize(-1);
  // A watcher must notice a daemon that disappeared without closing the connection.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
  // A proxy would see every case, and the address may exist only on this network.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 200);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  stub_ = v1::SimulationService::NewStub(
      grpc::CreateCustomChannel(server, grpc::InsecureChannelCredentials(), arguments));
}

void Connection::announce_retry(const grpc::Status& status, int attempts_made) const {
  std::cerr << "dccast: no answer from " << server_ << " (" << reason_of(status)
            << "); trying again (" << attempts_made << " of " << policy_.attempts - 1 << ")"
            << std::endl;
}

}  // namespace dccast::client
