#pragma once

#include <string>

#include "core/mechanics/slab_mechanics.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Rows that were merged before a step, and what that changed which it should not.
struct MergeOutcome {
  int rows = 0;               ///< of cells that were taken out
  double energy_error = 0.0;  ///< [1] relative change of the heat content
  mechanics::MergeChecks mechanics;
};

/// Outcome of one attempt at one step.
struct Attempt {
  bool converged = false;
  std::string why;         ///< heat or mechanics, when it did not converge
  double time_step = 0.0;  ///< [s]
  MergeOutcome merge;
  thermal::HeatStepOutcome heat;
  mechanics::StepOutcome mechanics;
};

}  // namespace dccast::casting
