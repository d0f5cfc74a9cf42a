#pragma once

#include "core/mechanics/slab_mechanics.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Chooses time steps: the step the case asks for, a smaller one after a step that did not
/// converge, growing back as steps succeed.
class StepControl {
public:
  /// @param smallest  [s] the run fails below this step
  explicit StepControl(double smallest) : smallest_(smallest) {}

  /// Step to try [s]. @param wanted  step the case asks for [s]
  double choose(double wanted) const { return wanted < limit_ ? wanted : limit_; }
  /// After a step that converged, larger steps are permitted again, by a factor of 2.
  void accepted() {
    constexpr double recovery = 2.0;
    if (limit_ < unlimited) limit_ *= recovery;
  }
  /// @param step  [s] step that did not converge @return false if no smaller step may be tried
  bool rejected(double step) {
    constexpr double cut = 0.5;
    limit_ = cut * step;
    return limit_ >= smallest_;
  }

  double limit() const { return limit_; }         ///< [s] for the checkpoint
  void restore(double limit) { limit_ = limit; }  ///< [s]

private:
  static constexpr double unlimited = 1e300;  ///< [s]
  double smallest_;                           ///< [s]
  double limit_ = unlimited;                  ///< [s]
};

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
  /// Outcome of the last solution; empty if the heat did not converge.
  mechanics::StepOutcome mechanics;
  bool converged() const { return diverged == Diverged::none; }
};

}  // namespace dccast::casting
