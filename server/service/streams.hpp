#pragma once

#include <grpcpp/support/server_callback.h>

#include "dccast/v1/service.pb.h"
#include "server/service/context.hpp"
#include "server/service/stream_call.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// The streaming calls of SimulationService; each reactor deletes itself when its call is done.
/// What has to be looked up before the first message is looked up in `lane`.
grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Context& context, WorkPool& lane, StreamCall call,
                                                  const v1::WatchJobRequest& request);
grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_result(
    Context& context, WorkPool& lane, StreamCall call, const v1::FetchResultRequest& request);

}  // namespace dccast::service
