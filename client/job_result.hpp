#pragma once

#include <string>

#include "client/connection.hpp"

namespace dccast::client {

/// The whole history of a job, read page by page and put together, with the case and, if asked for,
/// the last stored frame. When a resumption takes steps back while it is read, it is read again.
/// @return the status of the call that ended it; `result` is whole where it is OK
grpc::Status try_query_result(Connection& connection, const std::string& id, bool frame,
                              v1::QueryResultResponse& result);

/// The same without a frame. Throws CommandFailed for any status but OK.
v1::QueryResultResponse query_result(Connection& connection, const std::string& id);

}  // namespace dccast::client
