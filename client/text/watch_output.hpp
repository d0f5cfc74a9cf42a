#pragma once

#include "client/model/json.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// Turns events into the lines of `watch --json`. Every line has `sequence`, `event` (state, step,
/// message, resumed, validity_lost or finding), `state`, `step`, `time_s`, `cast_length_m`,
/// `iterations`, `beyond_validity`, `monitors` [{name, displacement_m}]; before the first step the
/// numbers are null. Events that are not steps repeat those of the last step.
class WatchOutput {
public:
  /// An event as one line of JSON.
  Json line(const v1::JobEvent& event);

private:
  v1::JobState state_ = v1::JOB_STATE_UNSPECIFIED;
  bool stepped_ = false;
  v1::StepReport step_;
};

}  // namespace dccast::client
