#pragma once

#include <string>
#include <vector>

#include "core/casting/simulation.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::translate {

/// @param monitors  of the case, in its order: the core's reports know them by number
v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors);

/// @param kind  what the end of the run says about the failure
v1::Failure to_proto(const casting::RunFailure& failure, v1::Failure::Kind kind);

}  // namespace dccast::translate
