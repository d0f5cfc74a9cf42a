#pragma once

#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"

namespace dccast::levers {

/// A sentence for speed and for water, where what was measured over the last minute is on average
/// more than 10 % off the plan.
/// @param plan      complete case
/// @param readings  by time
std::vector<std::string> levers_off_plan(const v1::Case& plan,
                                         const std::vector<v1::Reading>& readings);

/// How far speed and water have been off the plan until some time.
struct PlanDeparture {
  double time_s = 0.0;
  double share = 0.0;  ///< mean of |measured / planned - 1|, added over the levers
};

/// One for each reading, from 10 s after the start of the block: before, the block gathers speed.
/// @param plan      complete case
/// @param readings  by time
std::vector<PlanDeparture> plan_departures(const v1::Case& plan,
                                           const std::vector<v1::Reading>& readings);

}  // namespace dccast::levers
