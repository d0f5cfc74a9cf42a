#pragma once

#include <string>

#include "core/mechanics/step_outcome.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Outcome of one attempt at one step.
struct Attempt {
  bool converged = false;
  std::string why;         ///< heat or mechanics, when it did not converge
  double time_step = 0.0;  ///< [s]
  thermal::HeatStepOutcome heat;
  mechanics::StepOutcome mechanics;
};

}  // namespace dccast::casting
