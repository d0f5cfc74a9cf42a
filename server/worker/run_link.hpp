#pragma once

#include "core/casting/step_observer.hpp"
#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// Where a run sends what it has to say, and where its orders come from.
class RunLink {
public:
  virtual ~RunLink() = default;
  virtual void send(v1::WorkerMessage message) = 0;
  virtual casting::Order order() const = 0;
};

}  // namespace dccast::worker
