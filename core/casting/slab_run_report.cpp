// Report of a step, and frames of a run.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/casting/case/judged_monitor.hpp"
#include "core/casting/slab_run.hpp"
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
  r.gap_water_share = heat.gap_water.share();
  r.gap_wetted_share = heat.gap_water.wetted_share();
  r.water_boiled_away = wide.boiled_away || narrow.boiled_away;
  r.water_thrown_off = wide.thrown_off || narrow.thrown_off;
}

/// @param length  by which heat is divided: [m], billet [m/rad], quarter slab [1]
void report_heat(const Attempt& accepted, double length, results::StepReport& r) {
  const thermal::HeatBalance& balance = accepted.heat.balance;
  r.energy_balance_error = balance.error;
  r.wall_heat_flux = (balance.side + balance.bottom) / (accepted.time_step * length);
  r.side_heat = accepted.heat.face_heat_flux[std::size_t(thermal::Face::wide)] / length;
  r.narrow_heat = accepted.heat.face_heat_flux[std::size_t(thermal::Face::narrow)] / length;
  r.bottom_heat = accepted.heat.bottom_heat_flux / length;
  r.metal_heat = balance.entered / (accepted.time_step * length);
  r.level_heat = balance.top / (accepted.time_step * length);
  r.stored_heat = balance.stored / (accepted.time_step * length);
  report_water(accepted.heat, r);
}

void report_figures(const StepFigures& figures, results::StepReport& r) {
  r.sump_depth = figures.sump_depth;
  r.mould_exit_temperature = figures.mould_exit_temperature;
  r.shell_at_water_line = figures.exit_shell.value;
  r.least_shell = figures.least_shell.value;
  r.least_shell_depth = figures.least_shell_depth;
  r.shell_begins = figures.shell_begins.value;
  r.bottom_shell = figures.bottom_shell.value;
  r.mush_strain = figures.mush_strain.value;

  r.steam_share = figures.steam_share;
  r.residual_axial_depth = figures.residual.axial_depth.value_or(0.0);
  r.residual_hoop_depth = figures.residual.hoop_depth.value_or(0.0);
  if (figures.off_block) {
    r.off_block_curl = figures.off_block->curl;
    r.saw_off = figures.off_block->saw_off;
  }
  r.residual_tension = figures.residual.tension;
  r.elastic_energy = figures.residual.elastic_energy;

  r.pore_volume = figures.pore_volume;
  const TearIndices& tears = figures.tears;
  r.tear_rate = tears.strain_rate.overall;
  r.tear_rate_centre = tears.strain_rate.centre;
  r.tear_rate_surface = tears.strain_rate.surface;
  r.tear_pressure = tears.pressure.overall;
  r.tear_pressure_centre = tears.pressure.centre;
  r.tear_pressure_surface = tears.pressure.surface;
}

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

/// The motion of a slab, carried to a mesh of the heat's own.
template <int Dim>
mechanics::SlabState<Dim> motion_on_heat_mesh(const mechanics::SlabState<Dim>& slab,
                                              const mesh::PlanTransfer& transfer) {
  mechanics::SlabState<Dim> carried;
  carried.started = slab.started;
  carried.displacement = transfer.at_heat_nodes(slab.displacement, Dim);
  carried.solid = transfer.in_heat_elements(slab.solid);
  return carried;
}

}  // namespace

template <int Dim>
const mechanics::SlabState<Dim>& SlabRun<Dim>::reported_slab(
    bool stressed, std::optional<mechanics::SlabState<Dim>>& carried) const {
  const mesh::PlanTransfer& transfer = mesh_.transfer();
  if (transfer.same_mesh()) return state_.slab;

  carried = motion_on_heat_mesh(state_.slab, transfer);
  if (!stressed) return *carried;
  const std::size_t points = mechanics_.points();
  carried->viscoplastic = transfer.in_heat_elements(state_.slab.viscoplastic, points);
  carried->deviator = transfer.in_heat_elements(state_.slab.deviator, points);
  carried->pressure = transfer.in_heat_elements(state_.slab.pressure, points);
  return *carried;
}

template <int Dim>
MonitorReadings SlabRun<Dim>::read_monitors(std::span<const double> u) const {
  using Values = std::array<double, std::size_t(Dim) + 1>;  // displacement, then temperature
  const auto at_point = [&](const Monitor& point) {
    Values values;
    values.fill(std::nan(""));
    const auto place = fem::locate(mesh(), point_of<Dim>(point));
    if (!place) return values;
    for (int d = 0; d < Dim; ++d)
      values[std::size_t(d)] = fem::interpolate<Dim>(mesh(), *place, u, Dim, d);
    values.back() = fem::interpolate<Dim>(mesh(), *place, state_.heat.temperature);
    return values;
  };
  // Points first: means may stand before their points.
  std::vector<Values> values(case_.monitors.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (case_.monitors[i].of.empty()) values[i] = at_point(case_.monitors[i]);
  }
  const auto mean_of = [&](const std::vector<MonitorShare>& shares) {
    Values mean{};
    double weights = 0.0;
    for (const MonitorShare& share : shares) weights += share.weight;
    for (const MonitorShare& share : shares) {
      const auto point = std::ranges::find(case_.monitors, share.monitor, &Monitor::name);
      const Values& at = values[std::size_t(point - case_.monitors.begin())];
      for (std::size_t i = 0; i < at.size(); ++i) mean[i] += share.weight / weights * at[i];
    }
    return mean;
  };

  MonitorReadings readings;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& of = case_.monitors[i].of;
    const Values read = of.empty() ? values[i] : mean_of(of);
    readings.displacement.emplace_back(read.begin(), read.begin() + Dim);
    readings.temperature.push_back(read.back());
  }
  return readings;
}

template <int Dim>
StepFigures SlabRun<Dim>::measure(const Attempt& accepted, const MonitorReadings& monitors) {
  std::optional<mechanics::SlabState<Dim>> carried;
  const mechanics::SlabState<Dim>& slab = reported_slab(finished(), carried);
  const std::vector<double> in_mechanics = element_temperature();
  const std::vector<double> creep_rate =
      mesh_.transfer().in_heat_elements(meter_.tears().creep_rates(state_.slab, in_mechanics));

  const MechanicsView<Dim> own{.mesh = mesh_.mesh(),
                               .slab = state_.slab,
                               .element_temperature = in_mechanics,
                               .growing = mesh_.mesh().elements() - growing_elements(mesh_.mesh())};
  const StepView<Dim> view{.time = state_.time,
                           .time_step = accepted.time_step,
                           .cast_length = state_.cast_length,
                           .metal_level = metal_level(),
                           // Until the block starts, the mould's figures are those of the melt
                           // that has come so far.
                           .mould_level = state_.time > 0.0 ? mould_level() : metal_level(),
                           .last = finished(),
                           .mesh = mesh(),
                           .heat = accepted.heat,
                           .temperature = state_.heat.temperature,
                           .slab = slab,
                           .creep_rate = creep_rate,
                           .mechanics = own,
                           .checks = mechanics_.checks(),
                           .superheat = state_.superheat,
                           .level_heat = state_.level_heat,
                           .growing = mesh().elements() - growing_elements(mesh()),
                           .face_length = face_length_,
                           .monitor_displacement = monitors.displacement};
  StepFigures figures = meter_.measure(view, state_.findings.history);
  if (figures.last && figures.mechanical && case_.time.cool_down > 0.0)
    figures.off_block = lift_off_block(in_mechanics);
  return figures;
}

template <int Dim>
std::optional<OffBlock> SlabRun<Dim>::lift_off_block(std::span<const double> in_elements) {
  const std::vector<double> at_nodes = mesh_.transfer().at_mechanics_nodes(state_.heat.temperature);
  mechanics::SlabStepInput input;
  input.element_temperature = in_elements;
  input.node_temperature = at_nodes;
  input.metal_level = metal_level();
  input.element_temperature_n = in_elements;

  std::vector<double> u = mechanics_.off_block(state_.slab, input);
  if (u.empty()) return std::nullopt;
  u = mesh_.transfer().at_heat_nodes(std::move(u), Dim);

  // The slab rests on the lowest place of its butt.
  double lowest = INFINITY, before = INFINITY, highest = -INFINITY;
  for (const int n : block_.nodes) {
    const double height = mesh().point(n)[Dim - 1], rise = u[std::size_t(n) * Dim + Dim - 1];
    lowest = std::min(lowest, height + rise);
    before = std::min(before, height);
    highest = std::max(highest, rise);
  }
  const double sunk = lowest - before;
  for (std::size_t i = Dim - 1; i < u.size(); i += Dim) u[i] -= sunk;

  return OffBlock{judged_curl(case_, read_monitors(u).displacement), highest - sunk};
}

/// Number of elements in the row that stretches with the metal level; zero if the level no longer
/// rises.
template <int Dim>
int SlabRun<Dim>::growing_elements(const mesh::Mesh<Dim>& of) const {
  return mesh_.grows() ? of.elements() / mesh_.in_rows()->rows() : 0;
}

/// Mean surface temperature of the block [°C].
template <int Dim>
double SlabRun<Dim>::block_temperature() const {
  const std::vector<double>& columns = state_.heat.block_temperature;
  if (columns.empty()) return case_.cooling.bottom_block.temperature(state_.time);
  double sum = 0.0, area = 0.0;
  const std::span<const double> bottom = heat_.bottom_area();
  for (std::size_t i = 0; i < bottom.size(); ++i) {
    sum += bottom[i] * columns[i * thermal::BlockColumns::points];
    area += bottom[i];
  }
  return sum / area;
}

template <int Dim>
std::vector<double> SlabRun<Dim>::bottom_pressure() const {
  std::vector<double> at_nodes(std::size_t(mesh_.mesh().nodes()), 0.0);
  for (std::size_t i = 0; i < mechanics_.bottom_nodes().size(); ++i) {
    const double area = mechanics_.bottom_area()[i], reaction = state_.slab.reaction[i];
    if (area > 0.0)
      at_nodes[std::size_t(mechanics_.bottom_nodes()[i])] = std::max(0.0, reaction / area);
  }

  const std::vector<double> carried = mesh_.transfer().at_heat_nodes(std::move(at_nodes));
  std::vector<double> pressure;
  for (const int n : block_.nodes) pressure.push_back(carried[std::size_t(n)]);
  return pressure;
}

template <int Dim>
results::StepReport SlabRun<Dim>::report(const Attempt& accepted, int failed_attempts,
                                         const StepFigures& step, MonitorReadings monitors) const {
  results::StepReport r;
  r.dimension = Dim;
  r.step = state_.step;
  r.time = state_.time;
  r.cast_length = state_.cast_length;
  r.failed_attempts = failed_attempts;

  report_effort(accepted, r);
  report_merging(accepted.merge, r);
  report_heat(accepted, face_length_, r);
  r.block_temperature = block_temperature();
  report_figures(step, r);
  r.monitor_displacement = std::move(monitors.displacement);
  r.monitor_temperature = std::move(monitors.temperature);

  r.nodes = mesh().nodes();
  r.elements = mesh().elements();
  r.solver_seconds = state_.solver_seconds;
  r.process_seconds = state_.process_seconds;
  r.progress = (state_.time - schedule_.begin()) / (schedule_.end() - schedule_.begin());
  if (!state_.slab.started) return r;

  const mechanics::SlabChecks& checks = mechanics_.checks();
  r.equilibrium_residual = checks.equilibrium_residual;
  r.complementarity_error = checks.complementarity_error;
  r.bottom_reaction = step.bottom_reaction;
  r.weight = step.weight;
  (Dim == 2 ? r.contact_length : r.contact_area) = checks.contact_length;
  r.maximum_rotation = step.rotation.value;
  r.bottom_slip = step.slip.value;
  r.beyond_validity = state_.findings.lost.has_value();
  return r;
}

template <int Dim>
results::Frame SlabRun<Dim>::take_frame() {
  state_.next_frame = schedule_.next_frame(state_.time);
  results::Frame frame;
  frame.step = state_.step;
  frame.time = state_.time;
  frame.cast_length = state_.cast_length;
  frame.metal_level = metal_level();
  frame.dimension = Dim;
  frame.nodes_per_element = mesh().nodes_per_element;
  frame.node = mesh().node;
  frame.element_node.assign(mesh().element_node.begin(), mesh().element_node.end());
  frame.temperature = state_.heat.temperature;
  frame.liquid_fraction = state_.heat.liquid_fraction;
  std::optional<mechanics::SlabState<Dim>> carried;
  const bool stressed = case_.output.stresses && case_.mechanics.enabled;
  const mechanics::SlabState<Dim>& slab = reported_slab(stressed, carried);
  frame.displacement = slab.displacement;
  if (stressed) {
    add_stresses(slab, std::size_t(mesh().elements()), frame);
    for (const double t : frame.temperature)
      frame.thermal_strain.push_back(mechanics_.properties().thermal_stretch(t) - 1.0);
  }

  // The first frame comes before the first step, which follows the metal.
  const std::vector<MushPassage>& passages = state_.findings.history.passages;
  if (!passages.empty()) {
    TearMap tears = meter_.tears().map(passages);
    frame.tear_rate = std::move(tears.strain_rate);
    frame.tear_pressure = std::move(tears.pressure);
  }
  frame.bottom_node = block_.nodes;
  frame.bottom_gap = bottom_gap(frame.displacement);
  frame.bottom_pressure = bottom_pressure();
  return frame;
}

template MonitorReadings SlabRun<2>::read_monitors(std::span<const double>) const;
template StepFigures SlabRun<2>::measure(const Attempt&, const MonitorReadings&);
template results::StepReport SlabRun<2>::report(const Attempt&, int, const StepFigures&,
                                                MonitorReadings) const;
template results::Frame SlabRun<2>::take_frame();
template MonitorReadings SlabRun<3>::read_monitors(std::span<const double>) const;
template StepFigures SlabRun<3>::measure(const Attempt&, const MonitorReadings&);
template results::StepReport SlabRun<3>::report(const Attempt&, int, const StepFigures&,
                                                MonitorReadings) const;
template results::Frame SlabRun<3>::take_frame();

}  // namespace dccast::casting
