#include "client/session/failure.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

ExitCode exit_code_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::INVALID_ARGUMENT:
    case grpc::ALREADY_EXISTS:
    case grpc::OUT_OF_RANGE:
      return ExitCode::invalid;
    case grpc::NOT_FOUND:
    // To a caller without access an object does not exist.
    case grpc::PERMISSION_DENIED:
    case grpc::UNAUTHENTICATED:
      return ExitCode::not_found;
    case grpc::FAILED_PRECONDITION:
      return ExitCode::wrong_state;
    default:
      return ExitCode::unreachable;
  }
}

/// Connection errors reported by gRPC, which has no codes for them, and their meaning; the first
/// match is used.
using Wording = std::pair<std::string_view, std::string_view>;
constexpr std::array wordings{
    Wording{"Connection refused", "connection refused"},
    Wording{"No route to host", "no route to the host"},
    Wording{"Network is unreachable", "the network is unreachable"},
    Wording{"onnection reset", "the connection was reset"},
    Wording{"Broken pipe", "the connection was cut"},
    Wording{"Socket closed", "the connection was closed"},
    Wording{"GOAWAY", "the server closed the connection"},
    Wording{"http1.x server", "it is a web server, not dccastd"},
    Wording{"DNS resolution", "the name of the host cannot be resolved"},
    Wording{"name resolution", "the name of the host cannot be resolved"},
    Wording{"larger than max", "the message is larger than the server takes; see dccast info"},
    Wording{"failed to connect", "no connection"},
    Wording{"Failed parsing HTTP/2", "it does not speak gRPC"},
};

/// Parts of the reports that gRPC writes for its own developers.
bool is_trace(const std::string& message) {
  for (const char* const part : {"ipv4:", "ipv6:", "grpc_status", "last error", "C-ares", ".cc:"})
    if (message.find(part) != std::string::npos) return true;
  return false;
}

constexpr std::size_t longest_reason = 500;

}  // namespace

std::optional<refusal::Facts> refusal_of(const grpc::Status& status) {
  if (status.ok()) return std::nullopt;
  return refusal::read_details(status.error_details());
}

bool is_refused(const grpc::Status& status, refusal::Reason reason) {
  const auto facts = refusal_of(status);
  return facts && facts->reason == reason;
}

std::string reason_of(const grpc::Status& status) {
  const std::string& message = status.error_message();
  if (refusal_of(status)) return values::shortened(message, longest_reason);

  for (const auto& [sent, meaning] : wordings)
    if (message.find(sent) != std::string::npos) return std::string(meaning);
  if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED)
    return "it does not know this call: not dccastd, or another version of it";
  if (message.empty()) return "no reason given; the server's log may have one";
  return is_trace(message) ? "the connection failed" : values::shortened(message, longest_reason);
}

CommandFailed failure_of(const grpc::Status& status, const std::string& server) {
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE)
    return {ExitCode::unreachable,
            "no answer from " + server + " (" + reason_of(status) +
                "); is dccastd running there? Why calls fail: dccast doctor " + server +
                ". Another address: --server or DCCAST_SERVER",
            status};
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
    return {ExitCode::unreachable, "no answer from " + server + " in time; try again", status};
  const ExitCode code = exit_code_of(status.error_code());
  if (code != ExitCode::unreachable) return {code, reason_of(status), status};
  return {code, server + " could not answer: " + reason_of(status), status};
}

void check(const grpc::Status& status, const std::string& server) {
  if (!status.ok()) throw failure_of(status, server);
}

}  // namespace dccast::client
