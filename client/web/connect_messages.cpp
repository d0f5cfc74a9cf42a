#include "client/web/connect_messages.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/type.pb.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver_util.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <type_traits>

#include "client/html/frame_bytes.hpp"
#include "client/model/json.hpp"
#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

namespace pb = google::protobuf;

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

/// Descriptions of types. Protobuf would make them anew, with all options of the contract, for each
/// message, which takes longer than the message itself.
class KeptTypes final : public pb::util::TypeResolver {
public:
  pb::util::Status ResolveMessageType(const std::string& url, pb::Type* type) override {
    return resolve(url, *type, messages_, &TypeResolver::ResolveMessageType);
  }
  pb::util::Status ResolveEnumType(const std::string& url, pb::Enum* type) override {
    return resolve(url, *type, enums_, &TypeResolver::ResolveEnumType);
  }

private:
  template <class Type, class Resolve>
  pb::util::Status resolve(const std::string& url, Type& type, std::map<std::string, Type>& kept,
                           Resolve make) {
    {
      const std::shared_lock lock(mutex_);
      if (const auto found = kept.find(url); found != kept.end()) {
        type = found->second;
        return {};
      }
    }
    const pb::util::Status status = (makers_.get()->*make)(url, &type);
    if (!status.ok()) return status;  // a peer has made it up

    if constexpr (std::is_same_v<Type, pb::Type>)
      for (pb::Field& field : *type.mutable_fields()) field.clear_options();
    const std::lock_guard lock(mutex_);
    kept.emplace(url, type);
    return status;
  }

  const std::unique_ptr<TypeResolver> makers_{pb::util::NewTypeResolverForDescriptorPool(
      "type.googleapis.com", pb::DescriptorPool::generated_pool())};
  std::shared_mutex mutex_;
  std::map<std::string, pb::Type> messages_;
  std::map<std::string, pb::Enum> enums_;
};

pb::util::TypeResolver& types() {
  static KeptTypes kept;
  return kept;
}

std::string url_of(const std::string& type) {
  return "type.googleapis.com/" + type;
}

/// A detail in its binary form, and as JSON for people and scripts.
std::string detail_text(const pb::Any& detail) {
  const std::string type = detail.type_url().substr(detail.type_url().rfind('/') + 1);
  const bool is_info = type == "google.rpc.ErrorInfo";  // see refusal.proto
  const std::string debug =
      json_of_message(is_info ? v1::ErrorInfo::descriptor()->full_name() : type, detail.value());

  std::string encoded = base64(detail.value());
  encoded.erase(encoded.find_last_not_of('=') + 1);
  return fmt::format(R"({{"type":{},"value":"{}"{}}})", Json(type).dump(), encoded,
                     debug.empty() ? "" : R"(,"debug":)" + debug);
}

// ---- Streams: a byte of flags and four of length before each message

constexpr std::size_t prefix_bytes = 5;
constexpr char is_compressed = 1, is_end = 2;

/// A message of a stream behind its flags and length.
std::string flagged(char flags, const std::string& message) {
  std::string text(1, flags);
  for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(message.size() >> shift);
  return text + message;
}

}  // namespace

std::string json_of_message(const std::string& type, const std::string& bytes) {
  pb::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  if (!pb::util::BinaryToJsonString(&types(), url_of(type), bytes, &json, options).ok()) return {};
  return json;
}

std::string json_of_event(const std::string& type, const std::string& bytes) {
  struct Written {
    std::string type, bytes, json;
  };
  constexpr std::size_t most_bytes = 16'384;
  static std::mutex mutex;
  static std::array<Written, 8> recent;
  static std::size_t next = 0;
  if (bytes.size() > most_bytes) return json_of_message(type, bytes);

  // The streams that wait here want the same message, most likely.
  const std::lock_guard lock(mutex);
  for (const Written& each : recent)
    if (each.bytes == bytes && each.type == type) return each.json;
  Written& oldest = recent[next++ % recent.size()];
  oldest = {type, bytes, json_of_message(type, bytes)};
  return oldest.json;
}

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

Reply error_reply(const grpc::Status& status, const std::string& server) {
  Reply reply = json_reply(error_text(status, server));
  reply.status = code_of(status).http_status;
  return reply;
}

std::string enveloped(const std::string& message) {
  return flagged(0, message);
}

std::string end_of_stream(const grpc::Status& status, const std::string& server) {
  return flagged(is_end,
                 status.ok() ? "{}" : fmt::format(R"({{"error":{}}})", error_text(status, server)));
}

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

}  // namespace dccast::client
