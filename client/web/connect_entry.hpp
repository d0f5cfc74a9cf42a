#pragma once

#include "client/session/connection.hpp"
#include "client/web/web_server.hpp"

namespace dccast::client {

/// Answers POST /dccast.v1.SimulationService/METHOD by the Connect protocol
/// (https://connectrpc.com/docs/protocol): every method of the service, in JSON and in binary, with
/// its faults as gRPC reports them. Streams hold no thread.
Reply connect_reply(Connection& connection, const Request& request);

}  // namespace dccast::client
