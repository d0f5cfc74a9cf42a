#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class StressFreeOn : public ::testing::Test {
protected:
  static constexpr bool held_across = Element::dimension == 2 && !fem::is_axisymmetric<Element>;

  static auto block() {
    if constexpr (Element::dimension == 2) {
      return distorted_box<Element>({0.28, 0.1}, {8, 5});
    } else {
      return distorted_box<Element>({0.3, 0.2, 0.1}, {4, 3, 3});
    }
  }
};
TYPED_TEST_SUITE(StressFreeOn, AllFamilies);

/// A free block that cools evenly, without weight, held from below or on a floor it may leave:
/// nothing but the round-off of strains that cancel acts on it, and a residual of that size must
/// count as none. It shrinks by its thermal stretch, in plane strain by (1 + nu) times as much.
TYPED_TEST(StressFreeOn, ABlockWithoutWeightConvergesOnRoundOff) {
  constexpr double stretch = -0.02, young = 6e10, poisson = 0.3;
  constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson));
  for (const bool contact : {false, true}) {
    for (const Algorithm algorithm : all_algorithms) {
      FixedBody<TypeParam> body(this->block());
      body.set_material(young, poisson);
      for (double& thermal : body.problem.thermal) thermal = stretch;
      hold_symmetry(body);
      if (contact) {
        body.set_contact();
      } else {
        hold_low_end(body, body.dimension - 1);
      }

      Options options = tight(1e-9);
      options.algorithm = algorithm;
      options.parameters.gamma_c = 1e11;
      const auto outcome = body.step(options);
      EXPECT_TRUE(outcome.converged) << name_of(algorithm) << ", contact " << contact
                                     << ", residual " << outcome.equilibrium_residual;
      EXPECT_LE(outcome.contact_changes, 2);

      const double shrinkage = (this->held_across ? 1.0 + poisson : 1.0) * stretch;
      for (int n = 0; n < body.mesh.nodes(); ++n) {
        for (int d = 0; d < body.dimension; ++d) {
          EXPECT_NEAR(body.displacement(n, d), shrinkage * body.place(n)[std::size_t(d)], 1e-14);
        }
      }
      for (auto stress : body.stresses()) {
        if (this->held_across) stress[2] = 0.0;
        EXPECT_LE(stress.norm(), 1e-12 * bulk * 3.0 * std::abs(stretch));
      }
    }
  }
}

/// A plate colder below by a temperature linear in z bows without stress: the closed form of
/// u = a (x z, y z, (z^2 - x^2 - y^2) / 2). Cells as long as five times their height.
TEST(BendingHexahedron, APlateWithAThermalGradientBowsWithoutStress) {
  constexpr double gradient = 0.01;  // of the thermal stretch [1/m]
  constexpr int layers = 4;
  FixedBody<fem::BendingHexahedron> body(box_mesh({4, 3, layers}, false, [](const Vector3& s) {
    return Vector3{2.0 * s[0], 1.5 * s[1], 0.4 * (s[2] - 0.5)};
  }));
  body.set_material(1e9, 0.3);
  for (int e = 0; e < body.mesh.elements(); ++e) {
    body.problem.thermal[std::size_t(e)] = gradient * height_of(body.mesh, e);
  }
  hold_symmetry(body);
  body.fix(body.node_at({0.0, 0.0, 0.0}), 2, 0.0);
  ASSERT_TRUE(body.step(tight(1e-10)).converged);

  const double exact = -0.5 * gradient * (2.0 * 2.0 + 1.5 * 1.5);
  // One temperature by layer has the moment of a linear one less by one over the square of the
  // layers, and four layers bend to 0.963 of what thin plates do
  // (BendingHexahedron.LayersBring...).
  const double expected = (1.0 - 1.0 / (layers * layers)) * 0.963;
  EXPECT_NEAR(body.displacement(body.node_at({2.0, 1.5, 0.0}), 2) / exact, expected, 2e-3);
}

}  // namespace
}  // namespace dccast::mechanics
