#pragma once

#include "dccast/v1/worker.pb.h"
#include "server/worker/link_client.hpp"

namespace dccast::worker {

/// Runs a job and says how it ended. Never throws: whatever goes wrong is a failure of the job.
v1::WorkerMessage::Finished run_job(const v1::WorkerOrder::Start& start, LinkClient& link);

}  // namespace dccast::worker
