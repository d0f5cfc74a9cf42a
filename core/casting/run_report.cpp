#include "core/casting/run_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/fem/point_location.hpp"

namespace dccast::casting {

namespace {

void report_effort(const Attempt& accepted, results::StepReport& r) {
  r.time_step = accepted.time_step;
  r.iterations = accepted.mechanics.iterations;
  r.heat_iterations = accepted.heat.iterations;
  r.contact_changes = accepted.mechanics.contact_changes;
  r.factorizations = accepted.mechanics.factorizations + accepted.heat.factorizations;
  r.solves = accepted.mechanics.solves + accepted.heat.solves;
  r.conjugate_gradient_iterations = accepted.mechanics.gradient_iterations;
  r.constitutive_residual = accepted.mechanics.constitutive_residual;
}

void report_merging(const MergeOutcome& merge, results::StepReport& r) {
  r.merged_rows = merge.rows;
  r.merge_energy_error = merge.energy_error;
  r.merge_mass_error = merge.mechanics.mass_error;
  r.merge_equilibrium_error = merge.mechanics.equilibrium_error;
}

void report_water(const thermal::HeatStepOutcome& heat, results::StepReport& r) {
  const auto& [wide, narrow] = heat.water;
  r.water_share = wide.share();
  r.narrow_water_share = narrow.share();
  r.wetted_share = wide.wetted_share();
  r.narrow_wetted_share = narrow.wetted_share();
  r.water_boiled_away = wide.boiled_away || narrow.boiled_away;
  r.water_thrown_off = wide.thrown_off || narrow.thrown_off;
}

template <int Dim>
void report_heat(const ReportSource<Dim>& source, results::StepReport& r) {
  const Attempt& accepted = source.accepted;
  const thermal::HeatBalance& balance = accepted.heat.balance;
  const double length = source.face_length;
  r.energy_balance_error = balance.error;
  r.wall_heat_flux = (balance.side + balance.bottom) / (accepted.time_step * length);
  r.side_heat = accepted.heat.face_heat_flux[std::size_t(thermal::Face::wide)] / length;
  r.narrow_heat = accepted.heat.face_heat_flux[std::size_t(thermal::Face::narrow)] / length;
  r.bottom_heat = accepted.heat.bottom_heat_flux / length;
  r.metal_heat = balance.entered / (accepted.time_step * length);
  r.level_heat = balance.top / (accepted.time_step * length);
  r.stored_heat = balance.stored / (accepted.time_step * length);
  report_water(accepted.heat, r);
  r.block_temperature = source.block_temperature;
}

void report_figures(const StepFigures& figures, results::StepReport& r) {
  r.sump_depth = figures.sump_depth;
  r.mould_exit_temperature = figures.mould_exit_temperature;
  r.shell_at_exit = figures.exit_shell.value;
  r.bottom_shell = figures.bottom_shell.value;
  r.mush_strain = figures.mush_strain.value;
}

}  // namespace

template <int Dim>
MonitorReadings readings_of(const std::vector<Monitor>& monitors, const mesh::Mesh<Dim>& mesh,
                            const RunState<Dim>& state) {
  MonitorReadings readings;
  for (const Monitor& monitor : monitors) {
    const auto place = fem::locate(mesh, point_of<Dim>(monitor));
    std::vector<double> displacement(Dim, std::nan(""));
    for (int d = 0; place && d < Dim; ++d)
      displacement[std::size_t(d)] =
          fem::interpolate<Dim>(mesh, *place, state.slab.displacement, Dim, d);
    readings.displacement.push_back(std::move(displacement));
    readings.temperature.push_back(
        place ? fem::interpolate<Dim>(mesh, *place, state.heat.temperature) : std::nan(""));
  }
  return readings;
}

template <int Dim>
results::StepReport report_of(ReportSource<Dim> source, int failed_attempts) {
  const RunState<Dim>& state = source.state;
  results::StepReport r;
  r.dimension = Dim;
  r.step = state.step;
  r.time = state.time;
  r.cast_length = state.cast_length;
  r.failed_attempts = failed_attempts;
  report_effort(source.accepted, r);
  report_merging(source.accepted.merge, r);
  report_heat(source, r);
  report_figures(source.figures, r);
  r.monitor_displacement = std::move(source.monitors.displacement);
  r.monitor_temperature = std::move(source.monitors.temperature);
  r.nodes = source.mesh.nodes();
  r.elements = source.mesh.elements();
  r.solver_seconds = state.solver_seconds;
  r.process_seconds = state.process_seconds;
  const double begin = source.schedule.begin();
  r.progress = (state.time - begin) / (source.schedule.end() - begin);
  return r;
}

template MonitorReadings readings_of(const std::vector<Monitor>&, const mesh::Mesh<2>&,
                                     const RunState<2>&);
template MonitorReadings readings_of(const std::vector<Monitor>&, const mesh::Mesh<3>&,
                                     const RunState<3>&);
template results::StepReport report_of(ReportSource<2>, int);
template results::StepReport report_of(ReportSource<3>, int);

namespace {

/// Mean of a tensor over the points of each element, flat by element and component.
template <int Dim, class PointTensor>
std::vector<double> element_means(std::size_t elements, std::size_t points, PointTensor&& tensor) {
  std::vector<double> means;
  for (std::size_t e = 0; e < elements; ++e) {
    SymmetricTensor<Dim> mean;
    for (std::size_t q = 0; q < points; ++q) {
      mean.add(1.0 / static_cast<double>(points), tensor(e * points + q));
    }
    means.insert(means.end(), mean.value.begin(), mean.value.end());
  }
  return means;
}

template <int Dim>
void add_stresses(const mechanics::SlabState<Dim>& slab, std::size_t elements,
                  results::Frame& frame) {
  const std::size_t points = slab.deviator.size() / elements;
  frame.stress = element_means<Dim>(elements, points, [&](std::size_t i) {
    SymmetricTensor<Dim> stress = slab.deviator[i];
    return stress.add_identity(slab.pressure[i]);
  });
  frame.viscoplastic_strain =
      element_means<Dim>(elements, points, [&](std::size_t i) { return slab.viscoplastic[i]; });
}

template <int Dim>
void add_bottom(const FrameSource<Dim>& source, results::Frame& frame) {
  frame.bottom_node.assign(source.bottom_node.begin(), source.bottom_node.end());
  frame.bottom_gap.assign(source.bottom_gap.begin(), source.bottom_gap.end());
  for (std::size_t i = 0; i < source.bottom_node.size(); ++i) {
    const double area = source.bottom_area[i];
    const double reaction = source.state.slab.reaction[i];
    frame.bottom_pressure.push_back(area > 0.0 ? std::max(0.0, reaction / area) : 0.0);
  }
}

}  // namespace

template <int Dim>
results::Frame frame_of(const FrameSource<Dim>& source) {
  const mesh::Mesh<Dim>& mesh = source.mesh;
  const RunState<Dim>& state = source.state;
  results::Frame frame;
  frame.step = state.step;
  frame.time = state.time;
  frame.cast_length = state.cast_length;
  frame.metal_level = source.metal_level;
  frame.dimension = Dim;
  frame.nodes_per_element = mesh.nodes_per_element;
  frame.node = mesh.node;
  frame.element_node.assign(mesh.element_node.begin(), mesh.element_node.end());
  frame.temperature = state.heat.temperature;
  frame.liquid_fraction = state.heat.liquid_fraction;
  frame.displacement = state.slab.displacement;
  if (source.with_stresses) {
    add_stresses(state.slab, std::size_t(mesh.elements()), frame);
    for (const double t : frame.temperature)
      frame.thermal_strain.push_back(source.properties.thermal_stretch(t) - 1.0);
  }
  add_bottom(source, frame);
  return frame;
}

template results::Frame frame_of(const FrameSource<2>&);
template results::Frame frame_of(const FrameSource<3>&);

}  // namespace dccast::casting
