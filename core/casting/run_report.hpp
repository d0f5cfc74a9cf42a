#pragma once

#include <span>
#include <vector>

#include "core/case/case.hpp"
#include "core/case/casting_schedule.hpp"
#include "core/casting/run_state.hpp"
#include "core/casting/step_control.hpp"
#include "core/findings/figures.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/frame.hpp"
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

/// Input of frame_of(): the mesh, the state and the bottom of a run at one time.
template <int Dim>
struct FrameSource {
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  double metal_level = 0.0;             ///< [m]
  std::span<const int> bottom_node;     ///< nodes of the bottom, the order of the next two arrays
  std::span<const double> bottom_gap;   ///< [m] positive if open
  std::span<const double> bottom_area;  ///< [m2], in 2D [m]
  const material::MechanicalProperties& properties;
  bool with_stresses = false;  ///< and strains
};

/// The fields at one time. Stresses and strains are element means.
template <int Dim>
results::Frame frame_of(const FrameSource<Dim>& source);

extern template results::Frame frame_of(const FrameSource<2>&);
extern template results::Frame frame_of(const FrameSource<3>&);

}  // namespace dccast::casting
