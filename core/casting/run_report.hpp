#pragma once

#include "core/case/case.hpp"
#include "core/case/casting_schedule.hpp"
#include "core/casting/attempt.hpp"
#include "core/casting/run_state.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// Input of report_of(): an accepted step and the state of the run after it.
template <int Dim>
struct ReportSource {
  const Case& casting_case;
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  const Attempt& accepted;
  double metal_level;  ///< [m]
  double face_length;  ///< heat is divided by it: [m], billet [m/rad], quarter slab [1]
  const CastingSchedule& schedule;
};

/// The report of a step: progress, heat and monitors; of the mechanics only the counters of the
/// solvers.
/// @param failed_attempts  number of attempts before the accepted one
template <int Dim>
results::StepReport report_of(const ReportSource<Dim>& source, int failed_attempts);

extern template results::StepReport report_of(const ReportSource<2>&, int);
extern template results::StepReport report_of(const ReportSource<3>&, int);

}  // namespace dccast::casting
