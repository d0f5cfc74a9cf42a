#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/casting_schedule.hpp"
#include "core/casting/heat_source.hpp"
#include "core/casting/run_state.hpp"
#include "core/casting/step_control.hpp"
#include "core/casting/validity/validity.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// Outcome of one attempt at one step.
struct Attempt {
  bool converged = false;
  std::string why;  ///< heat or mechanics, when it did not converge
  double time_step = 0.0;  ///< [s]
  thermal::HeatStepOutcome heat;
  mechanics::StepOutcome mechanics;
};

/// The mesh of a run: the built-in one, which grows, or an imported one, which does not.
class RunMesh {
public:
  explicit RunMesh(const Case& casting_case);
  const mesh::Mesh2D& mesh() const { return slab_ ? slab_->mesh() : imported_; }
  bool grows() const { return slab_.has_value() && grows_; }
  mesh::SlabMesh2D& slab() { return *slab_; }
  const mesh::SlabMesh2D* built_in() const { return slab_ ? &*slab_ : nullptr; }

private:
  bool grows_;
  std::optional<mesh::SlabMesh2D> slab_;
  mesh::Mesh2D imported_;
};

/// One casting, step by step: growth, heat step, mechanical step, gap back to the heat of the next
/// (paper sections 2.1 and 2.2 alternate). Knows nothing of files.
class SlabRun {
public:
  /// @throws InvalidCase  a file of the case cannot be read
  explicit SlabRun(const Case& casting_case);

  const RunState& state() const { return state_; }
  /// Lists a failure of the step just made: part of the state, so that no resumption forgets it.
  void fail(RunFailure failure) { add_failure(state_.failures, std::move(failure)); }
  /// Why a state cannot be of this run: an array that does not fit the mesh, a time outside the
  /// case; empty when it can. Asked of a run that has made no step.
  std::string misfit(const RunState& state) const;
  /// Goes on from another state of the same case, one without a misfit.
  void restore(const RunState& state);

  bool finished() const;
  /// Makes one accepted step, cutting the time step as often as it takes.
  /// @throws SolveFailed  at the smallest time step
  results::StepReport advance();

  bool frame_is_due() const { return state_.time >= state_.next_frame - 1e-9 || finished(); }
  /// The fields of this instant; moves the time of the next frame on.
  results::Frame take_frame();
  const mesh::Mesh2D& mesh() const { return mesh_.mesh(); }
  int growth_row() const;

private:
  Attempt attempt(double dt);
  bool grow(double length, double temperature, std::optional<thermal::MetalEntry>& entry);
  bool step_heat(Attempt& tried, const thermal::HeatField& from,
                 const std::optional<thermal::MetalEntry>& entry);
  bool step_mechanics(Attempt& tried, const mechanics::SlabState<2>& from);
  std::vector<double> bottom_gap() const;
  double metal_level() const;
  results::StepReport report(const Attempt& accepted, int failed_attempts);
  void report_mechanics(results::StepReport& report);
  Extreme liquid_pressure_error() const;
  int growing_elements() const;

  Case case_;
  CastingSchedule schedule_;
  StepControl control_;
  RunMesh mesh_;
  HeatSource heat_;
  mechanics::SlabMechanics<2> mechanics_;
  double initial_level_;
  double face_length_;  ///< that heat and forces of a step stand for: 1 m, of a billet [m/rad]
  ValidityJudge validity_;
  RunState state_;
};

}  // namespace dccast::casting
