#pragma once

#include <google/protobuf/message.h>

#include <memory>

#include "client/session/connection.hpp"
#include "client/web/web_server.hpp"

namespace dccast::client {

/// Answers POST /dccast.v1.SimulationService/METHOD by the Connect protocol
/// (https://connectrpc.com/docs/protocol): every method of the service, in JSON and in binary, with
/// its faults as gRPC reports them. Streams hold no thread.
Reply connect_reply(Connection& connection, const Request& request);

/// Makes the unary call that a request names, with its body as JSON.
/// @param error  the reply where the call is refused
/// @return null: it is
std::unique_ptr<google::protobuf::Message> call_json(Connection& connection, const Request& request,
                                                     Reply& error);

}  // namespace dccast::client
