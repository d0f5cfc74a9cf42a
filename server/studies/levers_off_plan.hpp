#pragma once

#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"

namespace dccast::studies {

/// A sentence for speed and for water, where what was measured over the last minute is on average
/// more than 10 % off the plan.
/// @param plan      of a complete case
/// @param readings  by time
std::vector<std::string> levers_off_plan(const v1::Schedule& plan,
                                         const std::vector<v1::Reading>& readings);

}  // namespace dccast::studies
