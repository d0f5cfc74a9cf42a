#include "core/casting/findings/figures.hpp"
#include "core/material/thermal_properties.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/casting/case/judged_monitor.hpp"
#include "core/casting/findings/motion.hpp"
#include "core/casting/findings/mush_strain.hpp"
#include "core/casting/findings/shell.hpp"

namespace dccast::casting {

namespace {

/// Cast length from which metal at the water line is judged [m]: metal that was below it during
/// the hold had no water on purpose.
constexpr double first_metal_out = 5e-3;

/// Time between two measurements of sums over all elements [s], which cost more than other figures.
constexpr double between_sums = 5.0;

/// From this solid fraction on [1] the mush is as tough as solid metal; 0.94 to 0.99 by alloy
/// (docs/findings.md).
constexpr double tough_solid_fraction = 0.98;

/// Height of the lowest node [m]: 0 on a flat block, minus the depth of a bowl.
template <int Dim>
double lowest_height(const mesh::Mesh<Dim>& mesh) {
  double lowest = mesh.point(0)[Dim - 1];
  for (int n = 1; n < mesh.nodes(); ++n) lowest = std::min(lowest, mesh.point(n)[Dim - 1]);
  return lowest;
}

/// The node nearest to a place.
template <int Dim>
int find_nearest(const mesh::Mesh<Dim>& mesh, const std::vector<int>& nodes,
                 const std::array<double, Dim>& place) {
  const auto squared = [&](int n) {
    double sum = 0.0;
    for (std::size_t d = 0; d < Dim; ++d) sum += std::pow(mesh.point(n)[d] - place[d], 2);
    return sum;
  };
  return *std::ranges::min_element(nodes, {}, squared);
}

/// The largest lift of the monitors that are in the metal [m].
double greatest_lift(std::span<const std::vector<double>> displacement) {
  double most = -HUGE_VAL;
  for (const auto& u : displacement)
    if (std::isfinite(u.back())) most = std::max(most, u.back());
  return std::isfinite(most) ? most : 0.0;
}

/// The lift that is judged: that of output.curl, or the largest [m].
double judged_lift(const Case& c, std::span<const std::vector<double>> displacement) {
  if (c.output.curl.empty()) return greatest_lift(displacement);
  const double lift = judged_curl(c, displacement);
  return std::isfinite(lift) ? lift : 0.0;
}

/// Distance of the mould exit, where the water begins, below the metal level [m].
double mould_exit(const Case& c) {
  return c.cooling.water.from;
}

/// Distance below the metal level at which the mould contact, the uppermost zone, ends [m]; without
/// a zone the distance of the mould exit.
double contact_end(const Case& c) {
  const auto& zones = c.cooling.zones;
  if (zones.empty()) return mould_exit(c);
  return std::ranges::min_element(zones, {}, &thermal::SideZone::from)->to;
}

}  // namespace

template <int Dim>
StepMeter<Dim>::StepMeter(const Case& c)
    : case_(c),
      properties_(c.alloy),
      tears_(c.alloy, c.section),
      pores_(c.alloy, c.section.kind),
      isotherm_(c.alloy.shell_temperature()),
      fragile_above_(material::temperature_of_fraction(c.alloy, 1.0 - tough_solid_fraction)),
      solid_below_(c.mechanics.options.liquid == mechanics::Liquid::solid ? c.alloy.liquidus
                                                                          : c.alloy.coherency) {}

template <int Dim>
void StepMeter<Dim>::measure_water_line(const StepView<Dim>& view, StepFigures& f) const {
  const double height = view.mould_level - mould_exit(case_);
  f.mould_exit_temperature = side_temperature<Dim>(view.mesh, view.temperature, height);

  const auto slice = slice_at(view.mesh, view.temperature, std::max(0.0, height), isotherm_);
  if (!slice) return;  // a mesh without a side

  f.left_mould = height >= 0.0 && view.cast_length >= first_metal_out;
  f.left_contact = f.left_mould && view.cast_length >= contact_end(case_);
  f.exit_surface = slice->surface;
  f.exit_shell = f.least_shell = slice->shell;
  f.least_shell_depth = std::min(mould_exit(case_), view.mould_level);
}

/// Measures at a few heights only: a thin or remelted band is centimetres high. The lowest one is
/// the water line, which has been measured.
template <int Dim>
void StepMeter<Dim>::measure_gap(const StepView<Dim>& view, StepFigures& f) const {
  constexpr int heights = 4;
  const double begin = contact_end(case_), length = mould_exit(case_) - begin;
  if (length <= 0.0 || view.mould_level < begin) return;

  const auto slice_below_level = [&](double distance) {
    return slice_at(view.mesh, view.temperature, view.mould_level - distance, isotherm_);
  };
  const auto take = [&](const Slice<Dim>& slice, double distance) {
    if (slice.shell.value >= f.least_shell.value) return;
    f.least_shell = slice.shell;
    f.least_shell_depth = distance;
  };
  const auto entry = slice_below_level(begin);
  if (!entry) return;

  f.in_gap = true;
  f.gap_entry = entry->surface.value;
  f.entry_shell = entry->shell.value;
  take(*entry, begin);
  for (int i = 1; i < heights; ++i) {
    const double distance = begin + length * i / heights;
    if (distance > view.mould_level) return;
    const auto slice = slice_below_level(distance);
    if (!slice) return;

    if (slice->surface.value > f.gap_surface.value) f.gap_surface = slice->surface;
    take(*slice, distance);
  }
  // The exit from the mould has been measured with the water line.
  if (mould_exit(case_) <= view.mould_level && f.exit_surface.value > f.gap_surface.value)
    f.gap_surface = f.exit_surface;
}

template <int Dim>
void StepMeter<Dim>::measure_meniscus(const StepView<Dim>& view, StepFigures& f) const {
  f.shell_begins = unfrozen_side(view.mesh, view.temperature, isotherm_);
}

template <int Dim>
void StepMeter<Dim>::measure_bottom(const StepView<Dim>& view, StepFigures& f) const {
  const Located<Dim> shell = bottom_shell(view.mesh, view.temperature, isotherm_);
  f.bottom_shell = shell;

  const std::vector<int> nodes = mesh::patch_nodes(view.mesh, mesh::PatchKind::bottom);
  if (!f.mechanical || nodes.empty()) return;

  // Upwards from the block: a gap is open where the lift is positive.
  const auto lift = [&](int n) { return view.slab.displacement[std::size_t(n) * Dim + Dim - 1]; };
  f.gap_under_shell = std::max(0.0, lift(find_nearest<Dim>(view.mesh, nodes, shell.place)));

  const auto from_centre = [&](int n) {
    return std::hypot(view.mesh.point(n)[0], Dim == 3 ? view.mesh.point(n)[1] : 0.0);
  };
  const auto [centre, corner] = std::ranges::minmax(nodes, {}, from_centre);

  f.centre_lift = {lift(centre), {view.mesh.point(centre), view.mesh.point(centre) + Dim}};
  f.corner_lift = lift(corner);
  const int highest = *std::ranges::max_element(nodes, {}, lift);
  f.lift = {lift(highest), {view.mesh.point(highest), view.mesh.point(highest) + Dim}};
}

template <int Dim>
void StepMeter<Dim>::measure_closed_shell(const StepView<Dim>& view, StepFigures& f,
                                          FigureHistory& history) const {
  // A billet is held by its hoop stress, even if the shell below its axis melts.
  if (case_.section.kind == mesh::SectionKind::axisymmetric ||
      case_.mechanics.options.liquid == mechanics::Liquid::solid)
    return;

  // Without a limit the cheap test is enough while the shell is closed.
  const double limit = case_.validity.minimum_shell;
  if (limit <= 0.0 && !melt_touches_bottom(view.mesh, view.slab.solid)) {
    history.shell_stood = true;
    return;
  }

  auto shell = thinnest_shell(view.mesh, view.slab.solid);
  if (!shell) return;
  history.shell_stood |= shell->value > 0.0 && shell->value >= limit;
  if (history.shell_stood) f.closed_shell = std::move(shell);
}

/// Mush shears as melt does, without jamming the butt: its rotation counts only below coalescence.
template <int Dim>
std::vector<char> StepMeter<Dim>::grown_together(const MechanicsView<Dim>& view) const {
  std::vector<char> solid = view.slab.solid;
  if (!case_.alloy.mush) return solid;

  for (std::size_t e = 0; e < solid.size(); ++e) {
    if (view.element_temperature[e] > properties_.coalescence()) solid[e] = 0;
  }
  return solid;
}

template <int Dim>
void StepMeter<Dim>::measure_mechanics(const StepView<Dim>& view, StepFigures& f,
                                       FigureHistory& history) const {
  const mechanics::SlabChecks& checks = view.checks;
  f.weight = checks.weight / view.face_length;
  if (checks.weight > 0.0) f.steam_share = view.heat.steam_force / checks.weight;
  f.bottom_reaction = checks.bottom_reaction / view.face_length;

  // Faces lean on the wall and leave it node by node; what hangs up a slab lasts.
  constexpr double memory = 10.0;  // [s]
  history.wall_force += (checks.wall_reaction / view.face_length - history.wall_force) *
                        -std::expm1(-view.time_step / memory);
  if (f.weight > 0.0) f.wall_share = history.wall_force / f.weight;
  f.complementarity_error = checks.complementarity_error;

  // Largest motions of the solid, compared with the limits of small strains.
  const MechanicsView<Dim>& own = view.mechanics;
  f.rotation = largest_rotation(own.mesh, grown_together(own), own.slab.displacement, own.growing,
                                history.when_liquid);
  f.slip = largest_slip(view.mesh, view.slab.solid, view.slab.displacement, view.temperature,
                        properties_, solid_below_);

  measure_closed_shell(view, f, history);
}

template <int Dim>
void StepMeter<Dim>::measure_frozen_metal(const StepView<Dim>& view, StepFigures& f,
                                          FigureHistory& history) const {
  tears_.follow({.mesh = view.mesh,
                 .temperature = view.temperature,
                 .creep_rate = view.creep_rate,
                 .time = view.time_step,
                 .metal_level = view.metal_level,
                 .growing = view.growing},
                history.passages);

  // Sums over all metal take time: they are updated at intervals and at the end.
  const double before = view.time - view.time_step;
  if (view.last || std::floor(view.time / between_sums) > std::floor(before / between_sums)) {
    history.tears = tears_.indices(view.mesh, history.passages);
    history.pore_volume = pores_.volume(view.mesh, view.temperature) / view.face_length;
  }
  f.tears = history.tears;
  f.pore_volume = history.pore_volume;
}

template <int Dim>
StepFigures StepMeter<Dim>::measure(const StepView<Dim>& view, FigureHistory& history) const {
  StepFigures f;
  f.time = view.time;
  f.time_step = view.time_step;
  f.moves = f.time > 0.0 && f.time <= case_.time.end;
  f.last = view.last;
  f.mechanical = view.slab.started;
  f.solid_model = Dim == 3;

  f.energy_balance_error = view.heat.balance.error;
  f.superheat = view.superheat;
  f.level_heat = view.level_heat;
  for (const thermal::FaceWater& water : view.heat.water) {
    f.water_boiled_away = f.water_boiled_away || water.boiled_away;
    f.water_thrown_off = f.water_thrown_off || water.thrown_off;
    f.water_share = std::max(f.water_share, water.share());
  }

  f.metal_depth = view.metal_level - lowest_height(view.mesh);
  f.sump_depth =
      sump_depth<Dim>(view.mesh, view.temperature, view.metal_level, case_.alloy.coherency);

  // Figures of the temperature field, then those that need stresses.
  measure_water_line(view, f);
  measure_gap(view, f);
  measure_meniscus(view, f);
  measure_bottom(view, f);
  if (f.mechanical) measure_mechanics(view, f, history);

  const bool hoop = case_.section.kind == mesh::SectionKind::axisymmetric;
  if (f.last && f.mechanical && case_.time.cool_down > 0.0)
    f.residual = residual_stress(view.mesh, view.temperature, view.slab, properties_, hoop);

  const MechanicsView<Dim>& own = view.mechanics;
  f.mush_strain =
      mush_strain(own.mesh, own.slab, own.element_temperature, fragile_above_, own.growing, hoop);

  measure_frozen_metal(view, f, history);

  // The shell of the hold does not count: it stands on a block that does not move yet.
  if (f.moves)
    history.thickest_bottom_shell = std::max(history.thickest_bottom_shell, f.bottom_shell.value);
  f.thickest_bottom_shell = history.thickest_bottom_shell;
  f.greatest_curl = judged_lift(case_, view.monitor_displacement);
  return f;
}

template class StepMeter<2>;
template class StepMeter<3>;

}  // namespace dccast::casting
