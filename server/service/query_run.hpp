#pragma once

#include <grpcpp/support/status.h>

#include <functional>

#include "dccast/v1/service.pb.h"
#include "server/service/call.hpp"
#include "server/service/context.hpp"

namespace dccast::service {

using SendQueryResponse = std::function<void(v1::QueryButtCurlResponse)>;

/// Answers a query, from the store or by a run of its own, and returns when all is said: `send` is
/// called in order, from this thread, and must not wait. The run ends at once when the call is
/// cancelled. Must be called from a thread that lives as long as the daemon. May throw: guarded().
grpc::Status answer_query(Context& context, const Call& call,
                          const v1::QueryButtCurlRequest& request, const SendQueryResponse& send);

}  // namespace dccast::service
