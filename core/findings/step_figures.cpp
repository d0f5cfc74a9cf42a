#include "core/findings/step_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/findings/bottom_shell.hpp"
#include "core/findings/mush_strain.hpp"
#include "core/findings/slice.hpp"

namespace dccast::casting {

namespace {

/// Metal that was below the mould exit during the hold had no water on purpose; only metal that has
/// left the mould since then is judged [m].
constexpr double first_metal_out = 5e-3;

template <class Place>
PlacedFigure placed(double value, const Place& place) {
  return {value, {place.begin(), place.end()}};
}

template <int Dim>
void measure_exit(const Case& c, const StepView<Dim>& view, StepFigures& f) {
  const double height = view.metal_level - mould_exit(c);
  const auto slice = slice_at(view.mesh, view.temperature, std::max(0.0, height), c.alloy.solidus);
  if (!slice) return;  // a mesh without a side
  f.left_mould = height >= 0.0 && view.report.cast_length >= first_metal_out;
  f.exit_surface = placed(slice->hottest_surface, slice->hottest_at);
  f.exit_shell = placed(slice->shell, slice->thinnest_at);
}

/// Checks a few heights only: a remelted band is centimetres high.
template <int Dim>
void measure_gap(const Case& c, const StepView<Dim>& view, StepFigures& f) {
  constexpr int heights = 4;
  const double begin = contact_end(c), length = mould_exit(c) - begin;
  if (length <= 0.0 || view.metal_level < begin) return;
  const auto at = [&](double distance) {
    return hottest_side_at(view.mesh, view.temperature, view.metal_level - distance);
  };
  const auto entry = at(begin);
  if (!entry) return;
  f.in_gap = true;
  f.gap_entry = entry->value;
  for (int i = 1; i <= heights; ++i) {
    const double distance = begin + length * i / heights;
    if (distance > view.metal_level) return;
    const auto surface = at(distance);
    if (!surface || surface->value <= f.gap_surface.value) continue;
    f.gap_surface = placed(surface->value, surface->place);
  }
}

/// Node of the bottom that is nearest to a place.
template <int Dim>
int nearest_of(const mesh::Mesh<Dim>& mesh, const std::vector<int>& nodes,
               const std::array<double, Dim>& place) {
  const auto squared = [&](int n) {
    double sum = 0.0;
    for (std::size_t d = 0; d < Dim; ++d) sum += std::pow(mesh.point(n)[d] - place[d], 2);
    return sum;
  };
  return *std::ranges::min_element(nodes, {}, squared);
}

template <int Dim>
void measure_bottom(const Case& c, const StepView<Dim>& view, StepFigures& f) {
  const Located<Dim> shell = bottom_shell(view.mesh, view.temperature, c.alloy.solidus);
  f.bottom_shell = placed(shell.value, shell.place);
  const std::vector<int> nodes = mesh::patch_nodes(view.mesh, mesh::PatchKind::bottom);
  if (!f.mechanical || nodes.empty()) return;
  const auto lift = [&](int n) { return view.slab.displacement[std::size_t(n) * Dim + Dim - 1]; };
  f.gap_under_shell = std::max(0.0, lift(nearest_of<Dim>(view.mesh, nodes, shell.place)));
  const int highest = *std::ranges::max_element(nodes, {}, lift);
  f.lift = {lift(highest), {view.mesh.point(highest), view.mesh.point(highest) + Dim}};
}

template <int Dim>
void measure_mush(const Case& c, const StepView<Dim>& view, StepFigures& f) {
  const bool hoop = c.section.kind == mesh::SectionKind::axisymmetric;
  const auto strain =
      mush_strain(view.mesh, view.slab, view.temperature, c.alloy.solidus, view.growing, hoop);
  f.mush_strain = placed(strain.value, strain.place);
}

double greatest(std::span<const double> lifts) {
  double most = -HUGE_VAL;
  for (const double lift : lifts)
    if (std::isfinite(lift)) most = std::max(most, lift);
  return std::isfinite(most) ? most : 0.0;
}

}  // namespace

double mould_exit(const Case& c) {
  return c.cooling.water.from;
}

double contact_end(const Case& c) {
  const auto& zones = c.cooling.zones;
  if (zones.empty()) return mould_exit(c);
  return std::ranges::min_element(zones, {}, &thermal::SideZone::from)->to;
}

template <int Dim>
StepFigures figures_of(const Case& c, const StepView<Dim>& view, double& thickest_bottom_shell) {
  StepFigures f;
  f.time = view.report.time;
  f.moves = f.time > 0.0;
  f.last = view.report.progress >= 1.0;
  f.mechanical = view.slab.started;
  f.metal_depth = view.metal_level;
  f.sump_depth = view.report.sump_depth;
  measure_exit(c, view, f);
  measure_gap(c, view, f);
  measure_bottom(c, view, f);
  measure_mush(c, view, f);
  if (f.moves) thickest_bottom_shell = std::max(thickest_bottom_shell, f.bottom_shell.value);
  f.thickest_bottom_shell = thickest_bottom_shell;
  f.rotation = view.report.maximum_rotation;
  f.slip = view.report.bottom_slip;
  f.greatest_curl = greatest(view.monitor_lift);
  f.validity_lost = view.validity_lost;
  return f;
}

template StepFigures figures_of(const Case&, const StepView<2>&, double&);
template StepFigures figures_of(const Case&, const StepView<3>&, double&);

}  // namespace dccast::casting
