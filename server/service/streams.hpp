#pragma once

#include <grpcpp/support/server_callback.h>

#include "dccast/v1/service.pb.h"
#include "server/service/context.hpp"

namespace dccast::service {

/// The streaming calls of SimulationService; each reactor deletes itself when its call is done.
grpc::ServerWriteReactor<v1::JobEvent>* watch_job(Context& context,
                                                  const v1::WatchJobRequest& request);
grpc::ServerWriteReactor<v1::FetchResultResponse>* fetch_result(
    Context& context, const v1::FetchResultRequest& request);

}  // namespace dccast::service
