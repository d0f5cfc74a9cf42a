#pragma once

#include <grpcpp/support/status.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/web/request.hpp"

namespace google::protobuf {
class MethodDescriptor;
}

/// Messages and errors as the Connect protocol writes them (https://connectrpc.com/docs/protocol).
namespace dccast::client {

/// A message as JSON, with the names of the contract.
/// @param type  its full name. @return empty if the bytes are no message of this type
std::string json_of_message(const std::string& type, const std::string& bytes);

/// The same of a message of a stream. Streams that follow one job get the same ones at the same
/// time: each is written once.
std::string json_of_event(const std::string& type, const std::string& bytes);

/// Reads a request. @param bytes  receives it in binary. @return INVALID_ARGUMENT: it is no JSON of
/// the method's request
grpc::Status read_request(const google::protobuf::MethodDescriptor& method, bool is_json,
                          const std::string& body, std::string& bytes);

/// {code, message, details: [{type, value, debug}]}.
/// @param server  that was called, for the message where it does not answer; empty: it was not
std::string error_text(const grpc::Status& status, const std::string& server);
/// The same as the answer to a request, with the HTTP status of its code.
Reply error_reply(const grpc::Status& status, const std::string& server);

/// A message of a stream.
std::string enveloped(const std::string& message);
/// The last message of a stream.
std::string end_of_stream(const grpc::Status& status, const std::string& server);
/// The messages of a body. Empty: it is not made of whole ones without compression.
std::optional<std::vector<std::string>> messages_of(std::string_view body);

}  // namespace dccast::client
