#include "client/failure.hpp"

namespace dccast::client {
namespace {

ExitCode exit_code_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::ALREADY_EXISTS:
    case grpc::StatusCode::OUT_OF_RANGE:
      return ExitCode::invalid;
    case grpc::StatusCode::NOT_FOUND:
    case grpc::StatusCode::PERMISSION_DENIED:
    case grpc::StatusCode::UNAUTHENTICATED:
    case grpc::StatusCode::FAILED_PRECONDITION:
      return ExitCode::not_found;
    default:
      return ExitCode::unreachable;
  }
}

}  // namespace

CommandFailed failure_of(const grpc::Status& status, const std::string& server) {
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE)
    return {ExitCode::unreachable,
            "no answer from " + server + " (" + status.error_message() +
                "); is dccastd running there? Another address: --server or DCCAST_SERVER"};
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
    return {ExitCode::unreachable, "no answer from " + server + " in time; try again"};
  return {exit_code_of(status.error_code()), status.error_message()};
}

void check(const grpc::Status& status, const std::string& server) {
  if (!status.ok()) throw failure_of(status, server);
}

}  // namespace dccast::client
