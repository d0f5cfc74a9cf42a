#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/team.hpp"
#include "core/casting/attempt.hpp"
#include "core/casting/case.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/casting_schedule.hpp"
#include "core/casting/heat_source.hpp"
#include "core/casting/run_mesh.hpp"
#include "core/casting/run_state.hpp"
#include "core/casting/step_control.hpp"
#include "core/casting/validity/validity.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// Where a step begins that heat and mechanics take in several rounds.
template <int Dim>
struct StepStart {
  thermal::HeatField heat;
  mechanics::SlabState<Dim> slab;
};

/// A casting in the dimension of its section: growth, heat step, mechanical step, gap back to the
/// heat of the next (paper sections 2.1 and 2.2 alternate).
template <int Dim>
class SlabRun : public CastingRun {
public:
  /// @param threads  that share the work of a solid; a section takes one. The results do not depend
  ///                 on it
  /// @throws InvalidCase  a file of the case cannot be read
  explicit SlabRun(const Case& casting_case, int threads = 1);

  bool finished() const override;
  results::StepReport advance() override;
  double time() const override { return state_.time; }
  bool frame_is_due() const override;
  results::Frame take_frame() override;
  void fail(RunFailure failure) override { add_failure(state_.failures, std::move(failure)); }
  const RunFailures& failures() const override { return state_.failures; }
  const std::optional<ValidityLoss>& validity_lost() const override { return state_.validity.lost; }
  const std::vector<results::Finding>& findings() const override {
    return state_.plausibility.raised;
  }
  restart::Sections state_sections() const override { return to_sections(state_); }
  std::string restore(const restart::Sections& state) override;

  const RunState<Dim>& state() const { return state_; }
  const mesh::Mesh<Dim>& mesh() const { return mesh_.mesh(); }
  /// Where the seconds went, of the heat [s] and of the mechanics.
  double heat_seconds() const { return heat_seconds_; }
  const mechanics::CostSplit& mechanics_cost() const { return mechanics_.cost(); }
  /// Nodes of a row of the built-in mesh; 0 for an imported one.
  int growth_row() const;

private:
  double processor_seconds() const;
  void go_back_to(const RunState<Dim>& state);
  Attempt attempt(double dt);
  bool grow(double length, double temperature, std::optional<thermal::MetalEntry>& entry);
  MergeOutcome merge_rows();
  bool step_heat(Attempt& tried, const std::optional<thermal::MetalEntry>& entry);
  bool step_mechanics(Attempt& tried);
  std::vector<double> bottom_gap() const;
  std::vector<double> side_rise() const;
  double metal_level() const;
  results::StepReport report(const Attempt& accepted, int failed_attempts);
  void report_mechanics(results::StepReport& report);
  void judge_plausibility(results::StepReport& report);
  Extreme liquid_pressure_error() const;
  int growing_elements() const;

  Case case_;
  Team team_;
  CastingSchedule schedule_;
  StepControl control_;
  RunMesh<Dim> mesh_;
  HeatSource heat_;
  mechanics::SlabMechanics<Dim> mechanics_;
  double initial_level_;  ///< [m]
  /// That heat and forces of a step stand for: 1 m, of a billet [m/rad], of a quarter slab itself.
  double face_length_;
  bool has_profile_;  ///< the block is not flat
  ValidityJudge<Dim> validity_;
  RunState<Dim> state_;
  double heat_seconds_ = 0.0;  ///< [s] of the processor, steps and growth
};

extern template class SlabRun<2>;
extern template class SlabRun<3>;

}  // namespace dccast::casting
