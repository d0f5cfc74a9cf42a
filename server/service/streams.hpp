#pragma once

#include <grpcpp/support/server_callback.h>

#include <functional>

#include "dccast/v1/service.pb.h"
#include "server/service/call.hpp"
#include "server/service/context.hpp"
#include "server/service/stream_call.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// The streaming calls of SimulationService; each reactor deletes itself when its call is done.
/// What has to be looked up before the first message is looked up in `lane`.
grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Context& context, WorkPool& lane, StreamCall call,
                                                  const v1::WatchJobRequest& request);
grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_result(
    Context& context, WorkPool& lane, const StreamCall& call,
    const v1::FetchResultRequest& request);
/// Who calls, found out where it may take its time.
using CallMaker = std::function<Call()>;

/// Runs in `lane` from its beginning to its end. @param request  lives as long as the call
grpc::ServerWriteReactor<v1::QueryButtCurlResponse>* query_butt_curl(
    Context& context, WorkPool& lane, const CallMaker& call,
    const v1::QueryButtCurlRequest& request);

}  // namespace dccast::service
