#pragma once

#include <vector>
#include "core/case/case.hpp"
#include "core/case/casting_schedule.hpp"

#include "core/casting/attempt.hpp"
#include "core/casting/run_state.hpp"
#include "core/findings/figures.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// What the monitors show at the end of a step. A monitor above the metal level is not in the metal
/// yet: it has neither displacement nor temperature.
struct MonitorReadings {
  std::vector<std::vector<double>>
      displacement;                 ///< (monitor, coordinate) [m]; NaN above the level
  std::vector<double> temperature;  ///< (monitor) [°C]; NaN above the level
};

template <int Dim>
MonitorReadings readings_of(const std::vector<Monitor>& monitors, const mesh::Mesh<Dim>& mesh,
                            const RunState<Dim>& state);

/// Input of report_of(): an accepted step and the state of the run after it.
template <int Dim>
struct ReportSource {
  const Case& casting_case;
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  const Attempt& accepted;
  const StepFigures& figures;
  double face_length;  ///< heat is divided by it: [m], billet [m/rad], quarter slab [1]
  const CastingSchedule& schedule;
  double block_temperature;  ///< [°C] mean of its surface
  MonitorReadings monitors;
};

/// The report of a step: progress, heat, figures and monitors; of the mechanics only the counters
/// of the solvers. It decides nothing.
/// @param failed_attempts  number of attempts before the accepted one
template <int Dim>
results::StepReport report_of(ReportSource<Dim> source, int failed_attempts);

extern template MonitorReadings readings_of(const std::vector<Monitor>&, const mesh::Mesh<2>&,
                                            const RunState<2>&);
extern template MonitorReadings readings_of(const std::vector<Monitor>&, const mesh::Mesh<3>&,
                                            const RunState<3>&);
extern template results::StepReport report_of(ReportSource<2>, int);
extern template results::StepReport report_of(ReportSource<3>, int);

}  // namespace dccast::casting
