#pragma once

#include "dccast/v1/worker.pb.h"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// Whether what a run leaves in its directory is wanted.
enum class Results { kept, discarded };

/// Runs a job and says how it ended. Never throws: whatever goes wrong is a failure of the job.
v1::WorkerMessage::Finished run_job(const v1::WorkerOrder::Start& start, RunLink& link,
                                    Results results = Results::kept);

}  // namespace dccast::worker
