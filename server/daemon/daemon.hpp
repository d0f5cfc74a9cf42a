#pragma once

#include "dccast/v1/config.pb.h"
#include "server/daemon/worker_policy.hpp"

namespace dccast::daemon {

/// Serves until SIGTERM, SIGINT or SIGUSR1, which must be blocked in all threads. @return 0
/// @throws std::runtime_error  the address or the data directory cannot be used
int serve(const v1::DaemonConfig& config, const WorkerPolicy& workers);

}  // namespace dccast::daemon
