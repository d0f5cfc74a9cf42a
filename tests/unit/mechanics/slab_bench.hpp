#pragma once

#include <functional>
#include <tuple>
#include <utility>

#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/plan_transfer.hpp"
#include "tests/support/quarter_section.hpp"
#include "tests/unit/material/paper_card.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics::testing {

// Round-off of the stress is 1e-4 Pa. Where all of it is of the size of the metallostatic pressure
// that is 2e-9 of the forces that act, where metal cools 1e-13.
constexpr double hydrostatic = 1e-8, strained = 1e-11;

/// Fields of temperature over slabs of any dimension: one temperature everywhere, and a function of
/// the height.
inline auto uniform(double temperature) {
  return [temperature](auto...) { return temperature; };
}
template <class Function>
auto by_height(Function function) {
  return [function](auto... x) { return function(std::get<sizeof...(x) - 1>(std::tuple(x...))); };
}

/// Half a metre by 0.2 m and 0.12 m deep.
inline mesh::SectionSpec quarter_section(mesh::ElementKind element, const Curve& half_thickness) {
  mesh::SectionSpec spec = dccast::testing::quarter_section(element, {0.5, half_thickness, 0.12},
                                                            {5, 3, 3, 0.08, 0.05, 0.03});
  spec.growth_cell = 0.03;
  return spec;
}

/// A small slab with temperatures given by a function of place: a section, or a quarter whose wide
/// face is opened in two segments that meet at `kink`.
template <class Element>
class SlabBench {
public:
  static constexpr int dimension = Element::dimension;
  static constexpr bool solid = dimension == 3;
  static constexpr double width = solid ? 0.5 : 0.28, depth = solid ? 0.12 : 0.10, kink = 0.2;
  static constexpr double gravity = 9.81;
  using Field = verification::Field<double, dimension>;
  using Place = Vector<dimension>;
  using Tensor = SymmetricTensor<dimension>;

  explicit SlabBench(Options options = tight(hydrostatic),
                     const material::AlloyCard& card = material::testing::paper_card())
      : slab(section()),
        mechanics(std::make_unique<FormsOf<Element>>(), material::MechanicalProperties(card),
                  std::move(options)) {
    mechanics.set_mesh(slab.mesh());
    state = mechanics.initial_state();
  }
  SlabBench(const SlabBench&) = delete;

  /// Area of the bottom that forces are taken over [m2/m], of a billet [m2/rad], of a solid [m2].
  static double bottom() {
    if (solid) return kink * (0.22 + 0.215) / 2 + (width - kink) * (0.215 + 0.2) / 2;
    return fem::is_axisymmetric<Element> ? 0.5 * width * width : width;
  }
  std::vector<double> temperature(const Field& field) const {
    std::vector<double> t;
    for (int n = 0; n < slab.mesh().nodes(); ++n) t.push_back(std::apply(field, place(n)));
    return t;
  }
  /// (element) mean temperature [°C].
  std::vector<double> element_temperature(const Field& field) const {
    return mesh::PlanTransfer().element_means<dimension>(slab.mesh(), temperature(field));
  }
  void start(const Field& field) { mechanics.start(state, element_temperature(field)); }
  /// Expects the step to converge. @return iterations
  int step(const Field& field, double dt = 1.0) {
    const auto in_elements = element_temperature(field), at_nodes = temperature(field);
    const auto outcome = mechanics.step(state, {in_elements, at_nodes, dt, slab.level()});
    EXPECT_TRUE(outcome.converged) << outcome.equilibrium_residual;
    return outcome.iterations;
  }
  /// The same with the temperatures at the start of the step too.
  void step_between(const Field& before, const Field& after, double dt) {
    const auto start = element_temperature(before), end = element_temperature(after);
    const auto outcome = mechanics.step(state, {end, temperature(after), dt, slab.level(), start});
    EXPECT_TRUE(outcome.converged) << outcome.equilibrium_residual;
  }

  double metallostatic_pressure(int e) const {
    return 2360.0 * gravity * (slab.level() - height_of(slab.mesh(), e));
  }
  /// Expects the stress of an element to be minus the metallostatic pressure [Pa].
  void expect_metallostatic(int e, double tolerance) const {
    for (std::size_t q = 0; q < Element::points; ++q) {
      const std::size_t i = std::size_t(e) * Element::points + q;
      EXPECT_NEAR(state.pressure[i], -metallostatic_pressure(e), tolerance) << "element " << e;
      EXPECT_NEAR(state.deviator[i].norm(), 0.0, tolerance) << "element " << e;
    }
  }

  /// Total less inelastic strain at every point of the present mesh.
  std::vector<Tensor> elastic_strain() const {
    FormsOf<Element> forms;
    forms.update(slab.mesh());
    std::vector<Tensor> result;
    for (std::size_t i = 0; i < state.inelastic.size(); ++i) {
      result.push_back(forms.strain(i / Element::points, i % Element::points, state.displacement));
      result.back().add(-1.0, state.inelastic[i]);
    }
    return result;
  }

  Place place(int n) const {
    Place x;
    std::copy_n(slab.mesh().point(n), x.size(), x.begin());
    return x;
  }
  Place moved(int n) const {
    Place u;
    std::copy_n(&state.displacement[std::size_t(dimension * n)], u.size(), u.begin());
    return u;
  }
  double across(int n) const { return moved(n).front(); }
  double upwards(int n) const { return moved(n).back(); }
  /// Displacement along the outward normal of a patch.
  double outwards(int n, const mesh::Patch<dimension>& patch) const {
    const Place u = moved(n);
    double sum = 0.0;
    for (std::size_t d = 0; d < u.size(); ++d) sum += patch.normal[d] * u[d];
    return sum;
  }
  /// Calls `use(node, patch)` for the nodes of all patches of a kind, except for those at the kink,
  /// which have two normals.
  template <class Use>
  void for_each_node(mesh::PatchKind kind, Use&& use) const {
    for (const auto& patch : slab.mesh().patches) {
      if (patch.kind != kind) continue;
      for (int n : mesh::patch_nodes(patch)) {
        if (!solid || std::abs(place(n)[0] - kink) > 1e-9) use(n, patch);
      }
    }
  }

  mesh::SlabMesh<dimension> slab;
  SlabMechanics<dimension> mechanics;
  SlabState<dimension> state;

private:
  static mesh::SectionSpec section() {
    if (solid) {
      const Curve opened(Abscissa::distance, {0.0, kink, width}, {0.22, 0.215, 0.2});
      return quarter_section(kind_of<Element>, opened);
    }
    mesh::SectionSpec spec;
    spec.half_width = width;
    spec.initial_depth = depth;
    spec.element = kind_of<Element>;
    spec.columns = 6;
    spec.rows = 5;
    spec.side_cell = 0.03;
    spec.bottom_cell = 0.015;
    spec.growth_cell = 0.02;
    return spec;
  }
};

}  // namespace dccast::mechanics::testing
