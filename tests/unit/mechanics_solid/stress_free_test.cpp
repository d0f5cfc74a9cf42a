#include <gtest/gtest.h>

#include "tests/unit/mechanics_solid/solid_body.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class SolidStressFreeOn : public ::testing::Test {};
using Families = ::testing::Types<fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(SolidStressFreeOn, Families);

/// A free block that cools evenly, without weight, on a floor it may leave: it shrinks by its
/// thermal stretch, and a residual of the size of round-off must count as none.
TYPED_TEST(SolidStressFreeOn, ABlockWithoutWeightShrinksByItsThermalStretch) {
  constexpr double stretch = -0.0169;
  for (const Algorithm algorithm :
       {Algorithm::newton, Algorithm::vnbm, Algorithm::nbm, Algorithm::sbm}) {
    SolidBody<TypeParam> body(distorted_box({0.3, 0.2, 0.1}, {4, 3, 3}, of_tetrahedra<TypeParam>));
    body.set_material(6e10, 0.3);
    for (double& thermal : body.problem.thermal) thermal = stretch;
    for (int n : body.box.nodes_on(Face::x_low)) body.fix(n, 0, 0.0);
    for (int n : body.box.nodes_on(Face::y_low)) body.fix(n, 1, 0.0);
    body.set_contact();
    Options options = in_balance(1e-9);
    options.algorithm = algorithm;
    options.parameters.gamma_c = 1e11;
    const auto outcome = body.step(options);
    EXPECT_TRUE(outcome.converged)
        << "algorithm " << int(algorithm) << ", residual " << outcome.equilibrium_residual;
    for (int n = 0; n < body.box.mesh.nodes(); ++n) {
      for (int d = 0; d < 3; ++d) {
        EXPECT_NEAR(body.displacement(n, d), stretch * body.place(n)[std::size_t(d)], 1e-12);
      }
    }
  }
}

/// A plate colder below by a temperature linear in z bows without stress: the closed form of
/// u = a (x z, y z, (z^2 - x^2 - y^2) / 2). Cells as long as five times their height.
TEST(BendingHexahedron, APlateWithAThermalGradientBowsWithoutStress) {
  constexpr double gradient = 0.01;  // of the thermal stretch [1/m]
  constexpr int layers = 4;
  SolidBody<fem::BendingHexahedron> body(box_mesh({4, 3, layers}, false, [](const Vector3& s) {
    return Vector3{2.0 * s[0], 1.5 * s[1], 0.4 * (s[2] - 0.5)};
  }));
  body.set_material(1e9, 0.3);
  for (int e = 0; e < body.box.mesh.elements(); ++e) {
    const double z = 0.4 * ((e / (4 * 3) + 0.5) / layers - 0.5);
    body.problem.thermal[std::size_t(e)] = gradient * z;
  }
  for (int n : body.box.nodes_on(Face::x_low)) body.fix(n, 0, 0.0);
  for (int n : body.box.nodes_on(Face::y_low)) body.fix(n, 1, 0.0);
  body.fix(body.box.node(0, 0, layers / 2), 2, 0.0);
  ASSERT_TRUE(body.step(in_balance(1e-10)).converged);

  const int corner = body.box.node(4, 3, layers / 2);
  const double exact = -0.5 * gradient * (2.0 * 2.0 + 1.5 * 1.5);
  // One temperature by layer has the moment of a linear one less by one over the square of the
  // layers, and four layers bend to 0.963 of what thin plates do
  // (BendingHexahedron.LayersBring...).
  const double expected = (1.0 - 1.0 / (layers * layers)) * 0.963;
  EXPECT_NEAR(body.displacement(corner, 2) / exact, expected, 2e-3);
}

}  // namespace
}  // namespace dccast::mechanics
