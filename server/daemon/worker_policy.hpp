#pragma once

namespace dccast::daemon {

/// What becomes of running workers when their daemon goes.
struct WorkerPolicy {
  double patience_s = 300.0;  ///< [s] a worker runs on without a daemon; 0: it ends with its own
  bool left_running = false;  ///< by an orderly stop too, which else stops them at a checkpoint
};

}  // namespace dccast::daemon
