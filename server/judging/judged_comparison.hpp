#pragma once

#include <vector>

#include "dccast/v1/judgement.pb.h"
#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// Compares runs with the first one: sentences, the tables "keys" and "differences", charts of
/// curls, of their differences, and of the figures that differed before.
/// @param runs        two at least, each with a step
/// @param companions  further runs at another quality, which only give errors
v1::Judgement judge_comparison(const std::vector<JudgedRun>& runs,
                               const std::vector<JudgedRun>& companions);

}  // namespace dccast::judging
