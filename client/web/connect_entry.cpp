#include "client/web/connect_entry.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "client/html/judgement_parts.hpp"
#include "client/session/byte_call.hpp"
#include "client/web/connect_messages.hpp"

namespace dccast::client {
namespace {

namespace pb = google::protobuf;
using Clock = std::chrono::system_clock;

/// Value of Accept.
constexpr const char* with_html = "application/json; judgement=html";

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

/// A response as JSON, its judgement with its parts as HTML (pages ask for this).
std::string json_with_html(const pb::Descriptor& type, const std::string& bytes) {
  const std::unique_ptr<pb::Message> response(
      pb::MessageFactory::generated_factory()->GetPrototype(&type)->New());
  response->ParseFromString(bytes);
  Json json = to_json(*response);
  if (const auto* const field = type.FindFieldByName("judgement"))
    json[field->name()] = judgement_as_shown(dynamic_cast<const v1::Judgement&>(
        response->GetReflection()->GetMessage(*response, field)));
  return json.dump();
}

Reply unary_reply(Connection& connection, const Request& request, const Form& form,
                  const pb::MethodDescriptor& method) {
  std::string bytes, response;
  grpc::Status status = check_headers(request, form);
  if (status.ok()) status = read_request(method, form.is_json, request.body, bytes);
  if (!status.ok()) return error_reply(status, "");

  status = call_bytes(connection.channel(), method, std::move(bytes), *deadline_of(request, false),
                      response);
  if (!status.ok()) return error_reply(status, connection.server());
  const auto& type = *method.output_type();
  if (form.is_json)
    response = request.header("accept") == with_html ? json_with_html(type, response)
                                                     : json_of_message(type.full_name(), response);
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
      if (is_json) response = json_of_event(method.output_type()->full_name(), response);
      stream->write(enveloped(response), std::move(next));
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
    return error_reply({grpc::UNIMPLEMENTED, "there is no method " + request.name}, "");

  const auto form = form_of(request);
  if (!form || form->is_stream != (method->client_streaming() || method->server_streaming()))
    return {.body = {}, .status = 415};
  return form->is_stream ? stream_reply(connection, request, *form, *method)
                         : unary_reply(connection, request, *form, *method);
}

}  // namespace dccast::client
