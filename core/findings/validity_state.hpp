#pragma once

#include <optional>
#include <vector>

#include "core/restart/sections.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

using results::ValidityLoss;

/// The history needed to judge a step; a part of RunState.
struct ValidityState {
  bool shell_stood = false;          ///< a closed shell has existed, so that it can melt through
  std::vector<double> when_liquid;   ///< [rad] or [1], see largest_rotation()
  std::optional<ValidityLoss> lost;  ///< the first loss is kept
};

/// Converts the state to sections of a checkpoint, and back.
void write_validity(const ValidityState& state, restart::Sections& sections);
/// @throws std::out_of_range  a section is missing
ValidityState read_validity(const restart::Sections& sections);

}  // namespace dccast::casting
