#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/forms_of.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/plan_transfer.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/support/usual_options.hpp"
#include "tests/unit/material/paper_card.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics::testing {

// Round-off of the stress is 1e-4 Pa. Where all of it is of the size of the metallostatic pressure
// that is 2e-9 of the forces that act, where metal cools 1e-13.
constexpr double hydrostatic = 1e-8, strained = 1e-11;

inline Options balanced_to(double tolerance) {
  return dccast::testing::usual_options(tolerance);
}

/// A small slab section with temperatures given by a function of place.
template <class Element>
class SlabBench {
public:
  static constexpr double width = 0.28, depth = 0.10, gravity = 9.81;
  /// Area of the bottom that forces are taken over [m2/m], of a billet [m2/rad].
  static constexpr double face = fem::is_axisymmetric<Element> ? 0.5 * width * width : width;
  using Field = std::function<double(double, double)>;
  using Tensor = SymmetricTensor<2>;

  explicit SlabBench(Options options = balanced_to(hydrostatic),
                     const material::AlloyCard& card = material::testing::paper_card())
      : slab(section()),
        mechanics(std::make_unique<FormsOf<Element>>(), material::MechanicalProperties(card),
                  std::move(options)) {
    mechanics.set_mesh(slab.mesh());
    state = mechanics.initial_state();
  }
  SlabBench(const SlabBench&) = delete;

  std::vector<double> temperature(const Field& field) const {
    std::vector<double> t;
    for (int n = 0; n < slab.mesh().nodes(); ++n) {
      t.push_back(field(slab.mesh().point(n)[0], slab.mesh().point(n)[1]));
    }
    return t;
  }
  /// (element) mean temperature [°C].
  std::vector<double> element_temperature(const Field& field) const {
    return mesh::PlanTransfer().element_means<2>(slab.mesh(), temperature(field));
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

  double centroid_height(int e) const {
    double y = 0.0;
    for (int i = 0; i < Element::nodes; ++i) {
      y += slab.mesh().point(slab.mesh().nodes_of(e)[i])[1] / Element::nodes;
    }
    return y;
  }
  double metallostatic_pressure(int e) const {
    return 2360.0 * gravity * (slab.level() - centroid_height(e));
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
    for (int e = 0; e < slab.mesh().elements(); ++e) {
      for (std::size_t q = 0; q < Element::points; ++q) {
        result.push_back(forms.strain(std::size_t(e), q, state.displacement));
        result.back().add(-1.0, state.inelastic[result.size() - 1]);
      }
    }
    return result;
  }
  double across(int node) const { return state.displacement[2 * std::size_t(node)]; }
  double upwards(int node) const { return state.displacement[2 * std::size_t(node) + 1]; }

  mesh::SlabMesh2D slab;
  SlabMechanics<2> mechanics;
  SlabState<2> state;

private:
  static mesh::SectionSpec section() {
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
