#pragma once

#include <vector>

#include "core/restart/sections.hpp"
#include "core/results/finding.hpp"

namespace dccast::casting {

using results::Finding;
using results::Severity;

/// The history needed to judge a step; a part of RunState.
struct PlausibilityState {
  std::vector<Finding> raised;         ///< each code once, in the order in which they were raised
  double thickest_bottom_shell = 0.0;  ///< [m] since the block started to move
};

/// Converts the state to sections of a checkpoint, and back.
void write_plausibility(const PlausibilityState& state, restart::Sections& sections);
/// @throws std::out_of_range  a section is missing, names an unknown severity or a
///                            number has several values
PlausibilityState read_plausibility(const restart::Sections& sections);

}  // namespace dccast::casting
