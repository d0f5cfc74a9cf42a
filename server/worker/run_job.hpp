#pragma once

#include <cstddef>
#include <vector>

#include "core/casting/casting_run.hpp"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// Where the events of a run go, and where requests to stop it come from.
class RunLink {
public:
  virtual ~RunLink() = default;
  /// @throws std::system_error  the event cannot be kept: the run must not go on
  virtual void send(v1::JobEvent event) = 0;
  virtual casting::Order order() const = 0;
  /// The reports of the first steps that earlier attempts have sent, as the run that goes on has
  /// them; at most so many.
  virtual std::vector<v1::StepReport> steps(std::size_t) const { return {}; }
  /// Waits until what was sent is on the disk. @throws std::system_error
  virtual void sync() {}
};

/// Runs a case to its end. Never throws: whatever goes wrong is a failure of the job.
v1::RunEnd run_job(const v1::SolveCase& order, RunLink& link);

}  // namespace dccast::worker
