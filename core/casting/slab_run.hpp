#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/team.hpp"
#include "core/casting/case/case.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/findings/figures.hpp"
#include "core/casting/findings/judge.hpp"
#include "core/casting/heat_source.hpp"
#include "core/casting/run_mesh.hpp"
#include "core/casting/run_state.hpp"
#include "core/casting/step_control.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// Initial state of a step that iterates between heat and mechanics.
template <int Dim>
struct StepStart {
  /// Fields at the beginning of the step, to which every iteration returns.
  thermal::HeatField heat;
  mechanics::SlabState<Dim> slab;
};

/// The bottom of the heat's mesh and the block below it. Growth and merging leave it as it is.
template <int Dim>
struct BlockSurface {
  std::vector<int> nodes;
  std::vector<std::array<double, Dim>> normal;  ///< (bottom node) of the block, into the slab [1]
  std::vector<double> initial_gap;              ///< (bottom node) [m]; empty: none anywhere
};

/// What the monitors show at the end of a step. A monitor above the metal level is not in the metal
/// yet: it has neither displacement nor temperature.
struct MonitorReadings {
  /// (monitor, coordinate) [m]; NaN above the level
  std::vector<std::vector<double>> displacement;
  std::vector<double> temperature;  ///< (monitor) [°C]; NaN above the level
};

/// A casting in the dimension of its section. Each step grows the mesh, solves heat, then
/// mechanics; the gap found feeds back to the heat of the next step (paper sections 2.1 and 2.2
/// alternate).
template <int Dim>
class SlabRun : public CastingRun {
public:
  /// @param threads  number of threads for a solid; a 2D section uses one. The results do not
  ///                 depend on it
  /// @throws InvalidCase  a file of the case cannot be read
  explicit SlabRun(const Case& casting_case, int threads = 1);

  bool finished() const override;
  results::StepReport advance() override;
  double time() const override { return state_.time; }
  double next_time() const override { return state_.time + next_step(); }
  void append(const LeverReading& reading) override { schedule_.append(reading); }
  bool frame_is_due() const override;
  results::Frame take_frame() override;
  void fail(RunFailure failure) override { add_failure(state_.failures, std::move(failure)); }
  const RunFailures& failures() const override { return state_.failures; }
  const std::optional<ValidityLoss>& validity_lost() const override { return state_.findings.lost; }
  const std::vector<results::Finding>& findings() const override { return state_.findings.raised; }
  const std::vector<results::Margin>& margins() const override { return state_.findings.margins; }
  results::Sections state_sections() const override { return to_sections(state_); }
  [[nodiscard]] std::string restore(const results::Sections& state) override;

  const RunState<Dim>& state() const { return state_; }
  /// The mesh of the heat; all results are on its nodes and elements.
  const mesh::Mesh<Dim>& mesh() const { return mesh_.heat_mesh(); }
  /// Computing time of the heat [s] and of the mechanics.
  double heat_seconds() const { return heat_seconds_; }
  const mechanics::CostSplit& mechanics_cost() const { return mechanics_.cost(); }
  /// Nodes per row of a mesh of rows; 0 for an imported one.
  int growth_row() const;

private:
  /// Processor time of the calling thread and of the team so far [s].
  double processor_seconds() const;
  /// Time step to try next [s].
  double next_step() const { return control_.choose(schedule_.step_at(state_.time)); }
  /// Restores state and mesh after an attempt that did not converge.
  void go_back_to(const RunState<Dim>& state);
  /// @param dt  time step [s]
  Attempt attempt(double dt);
  /// Grows the mesh to a metal level [m] with metal of a temperature [°C]. @return whether it grew
  bool grow(double level, double temperature, std::optional<thermal::MetalEntry>& entry);
  /// Merges the rows that are deep enough below the metal level.
  MergeOutcome merge_rows();
  /// Solves the heat of a step. @return false if it did not converge
  [[nodiscard]] bool step_heat(Attempt& tried, const std::optional<thermal::MetalEntry>& entry);
  /// @param temperature_n  (element) at the start of the step, on the grown mesh [°C]
  [[nodiscard]] bool step_mechanics(Attempt& tried, std::span<const double> temperature_n);
  bool has_cooled_down() const;
  double block_temperature() const;  ///< [°C]
  /// (element of the mechanics' mesh) mean temperature [°C].
  std::vector<double> element_temperature() const;
  /// (node of the heat's mesh, coordinate) [m].
  std::vector<double> displacement() const;
  /// The slab on the heat's mesh.
  /// @param stressed  with its stresses and viscoplastic strains, which are large
  /// @param carried   storage for one that has to be carried there
  const mechanics::SlabState<Dim>& reported_slab(
      bool stressed, std::optional<mechanics::SlabState<Dim>>& carried) const;
  std::vector<double> bottom_pressure() const;  ///< (bottom node of the heat's mesh) [Pa]
  double metal_level() const;                   ///< [m]

  // Distances of the deformed slab from block, water lines and mould, on the heat's mesh.
  // u is displacement().
  std::vector<double> bottom_gap(std::span<const double> u) const;   ///< (bottom node) [m]
  std::vector<double> side_rise(std::span<const double> u) const;    ///< (node) [m]
  std::vector<double> side_inward(std::span<const double> u) const;  ///< (node, face) [m]

  /// [m] The level from which mould and water lines are counted, also while the mould is filled:
  /// where the metal stands unless schedule.metal_level moves it.
  double mould_level() const;
  /// Ends the casting once the curl that is judged has settled. @param monitors  of this step
  void end_where_settled(const MonitorReadings& monitors);
  /// Takes over that the casting ended before its plan.
  void end_casting(double time);
  /// Interpolates displacement and temperature at the monitors.
  /// @param u  (node of the heat's mesh, coordinate) [m]
  MonitorReadings read_monitors(std::span<const double> u) const;
  /// Lifts the slab that has cooled down off its block. Empty where that is not possible, @see
  /// SlabMechanics::off_block() @param in_elements  element_temperature() [°C]
  std::optional<OffBlock> lift_off_block(std::span<const double> in_elements);
  /// Figures of the accepted step. @param monitors  at its end
  StepFigures measure(const Attempt& accepted, const MonitorReadings& monitors);
  /// Raises the findings of a step and checks the limits of validity.
  void judge(const StepFigures& step);
  /// The report of the accepted step. @param failed_attempts  before the accepted one
  results::StepReport report(const Attempt& accepted, int failed_attempts, const StepFigures& step,
                             MonitorReadings monitors) const;
  /// Number of elements in the row that stretches with the metal level; 0 once it no longer rises.
  int growing_elements(const mesh::Mesh<Dim>& of) const;

  /// The case, and objects that follow from it and from state_.settled_at: none of them is part of
  /// the state of a run.
  Case case_;
  Team team_;
  CastingSchedule schedule_;
  StepControl control_;
  RunMesh<Dim> mesh_;
  HeatSource heat_;
  /// Mesh and solvers, whose state is in state_ alone.
  mechanics::SlabMechanics<Dim> mechanics_;
  /// Heat and forces of a step are per this length: 1 m in plane strain, of a billet [m/rad], of a
  /// quarter slab 1 (the totals) [1].
  double face_length_;
  BlockSurface<Dim> block_;
  StepMeter<Dim> meter_;
  RunState<Dim> state_;
  double heat_seconds_ = 0.0;  ///< [s] processor time of heat steps and growth
};

}  // namespace dccast::casting
