#pragma once

#include <string>

#include "core/mechanics/slab_mechanics.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Rows that were merged before a step, and the errors that the merging introduced.
struct MergeOutcome {
  int rows = 0;               ///< number of rows of cells that were removed
  double energy_error = 0.0;  ///< [1] relative change of the heat content
  mechanics::MergeChecks mechanics;
};

/// Outcome of one attempt at one step.
struct Attempt {
  bool converged = false;
  std::string why;         ///< "heat" or "mechanics" if it did not converge, else empty
  double time_step = 0.0;  ///< [s]
  MergeOutcome merge;
  double superheat = 0.0;  ///< [J/m], [J/rad], [J] of the metal that entered
  thermal::HeatStepOutcome heat;
  mechanics::StepOutcome mechanics;
};

}  // namespace dccast::casting
