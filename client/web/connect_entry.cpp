#include "client/web/connect_entry.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver_util.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <vector>

#include "client/html/frame_bytes.hpp"
#include "client/model/json.hpp"
#include "client/session/byte_call.hpp"

namespace dccast::client {
namespace {

namespace pb = google::protobuf;
using Clock = std::chrono::system_clock;

// ---- Codes

/// A code of gRPC as Connect names it, by its number, and the HTTP status of a unary call.
struct Code {
  const char* name;
  int http_status;
};
constexpr std::array codes{Code{"", 200},
                           Code{"canceled", 499},
                           Code{"unknown", 500},
                           Code{"invalid_argument", 400},
                           Code{"deadline_exceeded", 504},
                           Code{"not_found", 404},
                           Code{"already_exists", 409},
                           Code{"permission_denied", 403},
                           Code{"resource_exhausted", 429},
                           Code{"failed_precondition", 400},
                           Code{"aborted", 409},
                           Code{"out_of_range", 400},
                           Code{"unimplemented", 501},
                           Code{"internal", 500},
                           Code{"unavailable", 503},
                           Code{"data_loss", 500},
                           Code{"unauthenticated", 401}};

const Code& code_of(const grpc::Status& status) {
  const auto number = static_cast<std::size_t>(status.error_code());
  return codes.at(std::min(number, codes.size() - 1));
}

// ---- Messages

pb::util::TypeResolver& types() {
  static const std::unique_ptr<pb::util::TypeResolver> resolver(
      pb::util::NewTypeResolverForDescriptorPool("type.googleapis.com",
                                                 pb::DescriptorPool::generated_pool()));
  return *resolver;
}

std::string url_of(const std::string& type) {
  return "type.googleapis.com/" + type;
}

/// @return empty if the bytes are no message of this type
std::string json_of(const std::string& type, const std::string& bytes) {
  pb::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  if (!pb::util::BinaryToJsonString(&types(), url_of(type), bytes, &json, options).ok()) return {};
  return json;
}

/// Reads a request. @param bytes  receives it in binary
grpc::Status read_request(const pb::MethodDescriptor& method, bool is_json, const std::string& body,
                          std::string& bytes) {
  if (!is_json) {
    bytes = body;
    return grpc::Status::OK;
  }
  const auto read = pb::util::JsonToBinaryString(&types(), url_of(method.input_type()->full_name()),
                                                 body, &bytes);
  if (read.ok()) return grpc::Status::OK;
  return {grpc::INVALID_ARGUMENT,
          fmt::format("the request is no JSON of {}: {}", method.input_type()->full_name(),
                      std::string(read.message()))};
}

// ---- Errors

/// A detail in its binary form, and as JSON for people and scripts.
std::string detail_text(const pb::Any& detail) {
  const std::string type = detail.type_url().substr(detail.type_url().rfind('/') + 1);
  const bool is_info = type == "google.rpc.ErrorInfo";  // see refusal.proto
  const std::string debug =
      json_of(is_info ? v1::ErrorInfo::descriptor()->full_name() : type, detail.value());

  std::string encoded = base64(detail.value());
  encoded.erase(encoded.find_last_not_of('=') + 1);
  return fmt::format(R"({{"type":"{}","value":"{}"{}}})", type, encoded,
                     debug.empty() ? "" : R"(,"debug":)" + debug);
}

/// @param server  that was called; empty: it was not
std::string error_text(const grpc::Status& status, const std::string& server) {
  v1::StatusDetails details;
  const bool is_exact = server.empty() || refusal_of(status);
  if (is_exact) details.ParseFromString(status.error_details());

  std::string list;
  for (const pb::Any& detail : details.details())
    list += (list.empty() ? "" : ",") + detail_text(detail);
  const Json message(is_exact ? status.error_message() : failure_of(status, server).what());
  return fmt::format(R"({{"code":"{}","message":{},"details":[{}]}})", code_of(status).name,
                     message.dump(), list);
}

// ---- Streams: a byte of flags and four of length before each message

constexpr std::size_t prefix_bytes = 5;
constexpr char is_compressed = 1, is_end = 2;

std::string enveloped(char flags, const std::string& message) {
  std::string text(1, flags);
  for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(message.size() >> shift);
  return text + message;
}

std::string end_of_stream(const grpc::Status& status, const std::string& server) {
  return enveloped(
      is_end, status.ok() ? "{}" : fmt::format(R"({{"error":{}}})", error_text(status, server)));
}

/// The messages of a body. Empty: it is not made of whole ones without compression.
std::optional<std::vector<std::string>> messages_of(std::string_view body) {
  std::vector<std::string> messages;
  while (!body.empty()) {
    if (body.size() < prefix_bytes || body[0] == is_compressed) return std::nullopt;
    std::size_t size = 0;
    for (std::size_t i = 1; i < prefix_bytes; ++i)
      size = size << 8 | static_cast<unsigned char>(body[i]);
    body.remove_prefix(prefix_bytes);
    if (body.size() < size) return std::nullopt;
    messages.emplace_back(body.substr(0, size));
    body.remove_prefix(size);
  }
  return messages;
}

// ---- Requests

/// What the header of a request says of its messages.
struct Form {
  std::string type;  ///< of request and reply
  bool is_json, is_stream;
};

std::optional<Form> form_of(const Request& request) {
  std::string type = request.header("content-type");
  type.erase(std::min(type.find_first_of("; "), type.size()));
  for (const bool is_json : {true, false})
    for (const bool is_stream : {true, false})
      if (type ==
          fmt::format("application/{}{}", is_stream ? "connect+" : "", is_json ? "json" : "proto"))
        return Form{.type = type, .is_json = is_json, .is_stream = is_stream};
  return std::nullopt;
}

/// The deadline of a call: that of the caller, else of a unary call a minute.
/// @return empty: the caller's is no number of at most ten digits
std::optional<Clock::time_point> deadline_of(const Request& request, bool is_stream) {
  constexpr std::chrono::minutes usual{1};
  const std::string text = request.header("connect-timeout-ms");
  if (text.empty()) return is_stream ? Clock::time_point::max() : Clock::now() + usual;

  constexpr std::size_t most_digits = 10;
  std::int64_t ms = 0;
  const char* const end = text.data() + text.size();
  if (text.size() > most_digits || std::from_chars(text.data(), end, ms).ptr != end || ms < 0)
    return std::nullopt;
  return Clock::now() + std::chrono::milliseconds(ms);
}

/// What is wrong with the headers of a request, whose form is known.
grpc::Status check_headers(const Request& request, const Form& form) {
  const std::string version = request.header("connect-protocol-version");
  if (!version.empty() && version != "1")
    return {grpc::INVALID_ARGUMENT, "Connect-Protocol-Version is not 1"};
  const std::string coding =
      request.header(form.is_stream ? "connect-content-encoding" : "content-encoding");
  if (!coding.empty() && coding != "identity")
    return {grpc::INVALID_ARGUMENT, "requests are sent without compression"};
  if (!deadline_of(request, form.is_stream))
    return {grpc::INVALID_ARGUMENT, "Connect-Timeout-Ms is no number of at most ten digits"};
  return grpc::Status::OK;
}

// ---- Calls

/// The error of a unary call.
Reply connect_error(const grpc::Status& status, const std::string& server) {
  return {.body = error_text(status, server), .status = code_of(status).http_status};
}

/// Calls a unary method. @param response  receives its answer in binary
/// @return the error; empty: there is none
std::optional<Reply> call_unary(Connection& connection, const Request& request, bool is_json,
                                const pb::MethodDescriptor& method, std::string& response) {
  std::string bytes;
  const grpc::Status read = read_request(method, is_json, request.body, bytes);
  if (!read.ok()) return connect_error(read, "");

  const grpc::Status status = call_bytes(connection.channel(), method, std::move(bytes),
                                         *deadline_of(request, false), response);
  if (!status.ok()) return connect_error(status, connection.server());
  return std::nullopt;
}

Reply unary_reply(Connection& connection, const Request& request, const Form& form,
                  const pb::MethodDescriptor& method) {
  const grpc::Status status = check_headers(request, form);
  if (!status.ok()) return connect_error(status, "");
  std::string response;
  if (auto error = call_unary(connection, request, form.is_json, method, response)) return *error;

  if (form.is_json) response = json_of(method.output_type()->full_name(), response);
  return {.body = std::move(response), .type = form.type};
}

grpc::Status read_messages(const pb::MethodDescriptor& method, const Request& request,
                           const Form& form, std::vector<std::string>& requests) {
  grpc::Status status = check_headers(request, form);
  if (!status.ok()) return status;
  const auto messages = messages_of(request.body);
  if (!messages || messages->empty() || (messages->size() > 1 && !method.client_streaming()))
    return {grpc::INVALID_ARGUMENT,
            "the body is not made of whole messages, each behind a zero and its length"};
  for (const std::string& message : *messages) {
    status = read_request(method, form.is_json, message, requests.emplace_back());
    if (!status.ok()) break;
  }
  return status;
}

Reply stream_reply(Connection& connection, const Request& request, const Form& form,
                   const pb::MethodDescriptor& method) {
  std::vector<std::string> requests;
  const grpc::Status status = read_messages(method, request, form, requests);
  if (!status.ok()) return {.body = end_of_stream(status, ""), .type = form.type};

  const auto write = [channel = connection.channel(), server = connection.server(), &method,
                      requests = std::move(requests), deadline = *deadline_of(request, true),
                      is_json = form.is_json,
                      place = request.place](const std::shared_ptr<http::Stream>& stream) {
    const auto received = [stream, &method, is_json](std::string response, auto next) {
      if (is_json) response = json_of(method.output_type()->full_name(), response);
      stream->write(enveloped(0, response), std::move(next));
    };
    const auto ended = [stream, server, place](const grpc::Status& end) {
      stream->write(end_of_stream(end, server), [stream](bool) { stream->end(); });
    };
    stream->when_left(begin_call(channel, {.method = method,
                                           .requests = requests,
                                           .deadline = deadline,
                                           .received = received,
                                           .ended = ended}));
  };
  return {.body = {}, .type = form.type, .stream = write};
}

}  // namespace

Reply connect_reply(Connection& connection, const Request& request) {
  const auto* const method = find_method(request.name);
  if (method == nullptr)
    return connect_error({grpc::UNIMPLEMENTED, "there is no method " + request.name}, "");

  const auto form = form_of(request);
  if (!form || form->is_stream != (method->client_streaming() || method->server_streaming()))
    return {.body = {}, .status = 415};
  return form->is_stream ? stream_reply(connection, request, *form, *method)
                         : unary_reply(connection, request, *form, *method);
}

std::unique_ptr<pb::Message> call_json(Connection& connection, const Request& request,
                                       Reply& error) {
  const auto& method = *find_method(request.name);
  std::string answered;
  if (auto failed = call_unary(connection, request, true, method, answered)) {
    error = std::move(*failed);
    return nullptr;
  }

  auto* const factory = pb::MessageFactory::generated_factory();
  std::unique_ptr<pb::Message> response(factory->GetPrototype(method.output_type())->New());
  response->ParseFromString(answered);
  return response;
}

}  // namespace dccast::client
