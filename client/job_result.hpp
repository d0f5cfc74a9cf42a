#pragma once

#include <string>

#include "client/connection.hpp"

namespace dccast::client {

/// Reads the whole history of a job, page by page, with the case and, on request, the last stored
/// frame. If the job is resumed from an earlier step meanwhile, the history is read again.
/// @return the status of the last call; `result` is complete if it is OK
grpc::Status try_query_result(Connection& connection, const std::string& id, bool frame,
                              v1::QueryResultResponse& result);

/// The same without a frame. Throws CommandFailed for any status but OK.
v1::QueryResultResponse query_result(Connection& connection, const std::string& id);

}  // namespace dccast::client
