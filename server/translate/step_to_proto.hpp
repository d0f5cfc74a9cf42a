#pragma once

#include <string>
#include <vector>

#include "core/casting/simulation.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::translate {

/// @param monitors  of the case, in its order: the core's reports know them by number
v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors);

/// The same report, bit by bit. @param dimension  2 in sections, 3 in quarter slabs
results::StepReport to_core(const v1::StepReport& report, int dimension);

/// @param failures  of a run, the cause first; at least one
v1::Failure to_proto(const casting::RunFailures& failures);

v1::ValidityLoss to_proto(const results::ValidityLoss& loss);

v1::Finding to_proto(const results::Finding& finding);

}  // namespace dccast::translate
