#pragma once

#include "core/mechanics/slab_mechanics.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Rows that were merged before a step, and the errors that the merging introduced.
struct MergeOutcome {
  int rows = 0;               ///< number of rows of cells that were removed
  double energy_error = 0.0;  ///< [1] relative change of the heat content
  mechanics::MergeChecks mechanics;
};

/// The part of a step that did not converge.
enum class Diverged { none, heat, mechanics };

/// Outcome of one attempt at one step.
struct [[nodiscard]] Attempt {
  Diverged diverged = Diverged::none;
  double time_step = 0.0;  ///< [s]
  MergeOutcome merge;
  double superheat = 0.0;  ///< [J/m], [J/rad], [J] of the metal that entered
  thermal::HeatStepOutcome heat;
  mechanics::StepOutcome mechanics;
  bool converged() const { return diverged == Diverged::none; }
};

}  // namespace dccast::casting
