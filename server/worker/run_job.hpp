#pragma once

#include "dccast/v1/worker.pb.h"
#include "server/worker/run_link.hpp"

namespace dccast::worker {

/// Whether what a run leaves in its directory is wanted.
enum class Results { kept, discarded };

/// Runs a case to its end. Never throws: whatever goes wrong is a failure of the job.
v1::RunEnd run_job(const v1::WorkerOrder& order, RunLink& link, Results results = Results::kept);

}  // namespace dccast::worker
