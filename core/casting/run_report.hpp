#pragma once

#include "core/casting/attempt.hpp"
#include "core/casting/case.hpp"
#include "core/casting/casting_schedule.hpp"
#include "core/casting/run_state.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// A step that was accepted, and where the run is after it.
template <int Dim>
struct ReportSource {
  const Case& casting_case;
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  const Attempt& accepted;
  double metal_level;  ///< [m]
  double face_length;  ///< what heat is divided by: [m], of a billet [m/rad], of a quarter slab [1]
  const CastingSchedule& schedule;
};

/// What a step reports of its course, its heat and its monitors; of the mechanics only what the
/// solvers counted.
/// @param failed_attempts  before the accepted one
template <int Dim>
results::StepReport report_of(const ReportSource<Dim>& source, int failed_attempts);

extern template results::StepReport report_of(const ReportSource<2>&, int);
extern template results::StepReport report_of(const ReportSource<3>&, int);

}  // namespace dccast::casting
