#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "core/mechanics/forms_of.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/plan_transfer.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/support/quarter_section.hpp"
#include "tests/support/usual_options.hpp"
#include "tests/unit/material/paper_card.hpp"
#include "tests/unit/mechanics_solid/box_mesh.hpp"

namespace dccast::mechanics::testing {

/// Half a metre by 0.2 m and 0.12 m deep, its wide face straight or opened in two segments.
inline mesh::SectionSpec quarter_section(mesh::ElementKind element, bool opened) {
  const Curve opening =
      opened ? Curve(Abscissa::distance, {0.0, 0.2, 0.5}, {0.22, 0.215, 0.2}) : Curve(0.2);
  mesh::SectionSpec spec =
      dccast::testing::quarter_section(element, {0.5, opening, 0.12}, {5, 3, 3, 0.08, 0.05, 0.03});
  spec.growth_cell = 0.03;
  return spec;
}

/// A small quarter slab with temperatures given by a function of place.
template <class Element>
class QuarterSlab {
public:
  using Field = std::function<double(const Vector3&)>;
  static constexpr mesh::ElementKind kind =
      Element::nodes == 4 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;

  explicit QuarterSlab(Options options, bool opened = false)
      : slab(quarter_section(kind, opened)),
        mechanics(std::make_unique<FormsOf<Element>>(),
                  material::MechanicalProperties(material::testing::paper_card()),
                  std::move(options)) {
    mechanics.set_mesh(slab.mesh());
    state = mechanics.initial_state();
  }
  QuarterSlab(const QuarterSlab&) = delete;

  std::vector<double> temperature(const Field& field) const {
    std::vector<double> t;
    for (int n = 0; n < slab.mesh().nodes(); ++n) t.push_back(field(place(n)));
    return t;
  }
  /// (element) mean temperature [°C].
  std::vector<double> element_temperature(const Field& field) const {
    return mesh::PlanTransfer().element_means<3>(slab.mesh(), temperature(field));
  }
  void start(const Field& field) { mechanics.start(state, element_temperature(field)); }
  /// Expects the step to converge. @return iterations
  int step(const Field& field, double dt = 1.0) {
    const auto in_elements = element_temperature(field), at_nodes = temperature(field);
    const auto outcome = mechanics.step(state, {in_elements, at_nodes, dt, slab.level()});
    EXPECT_TRUE(outcome.converged) << outcome.equilibrium_residual;
    return outcome.iterations;
  }
  Vector3 place(int n) const {
    const double* x = slab.mesh().point(n);
    return {x[0], x[1], x[2]};
  }
  Vector3 moved(int n) const {
    const double* u = &state.displacement[3 * std::size_t(n)];
    return {u[0], u[1], u[2]};
  }
  /// Displacement towards the mould of the nodes of a patch that no other side or plane shares.
  double outwards(int n, const mesh::Patch<3>& patch) const {
    double sum = 0.0;
    for (std::size_t d = 0; d < 3; ++d) sum += patch.normal[d] * moved(n)[d];
    return sum;
  }

  mesh::SlabMesh3D slab;
  SlabMechanics<3> mechanics;
  SlabState<3> state;
};

inline Options slab_options(double tolerance = 1e-9) {
  return dccast::testing::usual_options(tolerance);
}

}  // namespace dccast::mechanics::testing
