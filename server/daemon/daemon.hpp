#pragma once

#include <signal.h>

#include "dccast/v1/config.pb.h"
#include "server/daemon/settings.hpp"

namespace dccast::daemon {

/// SIGTERM, SIGINT and SIGUSR1.
sigset_t awaited_signals();

/// Serves until one of them comes; they must be blocked in all threads. @return 0
/// @throws std::runtime_error  the address or the data directory cannot be used
int serve(const v1::DaemonConfig& config, const WorkerPolicy& workers);

}  // namespace dccast::daemon
