#pragma once

#include "core/casting/casting_run.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::worker {

/// Where the events of a run go, and where requests to stop it come from.
class RunLink {
public:
  virtual ~RunLink() = default;
  /// @throws std::system_error  the event cannot be kept: the run must not go on
  virtual void send(v1::JobEvent event) = 0;
  virtual casting::Order order() const = 0;
  /// The step up to which the history goes that has been sent by earlier attempts; 0: none.
  virtual std::int64_t reached_step() const { return 0; }
};

}  // namespace dccast::worker
