#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double young = 4e10, poisson = 0.45, exponent = 6.0;
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson));

Vector2 linear(double x, double y) {
  return {1e-4 + 2e-3 * x - 7e-4 * y, -3e-4 + 1e-3 * x - 1.5e-3 * y};
}
const PlaneStress strain{{2e-3, -1.5e-3, 0.0, 0.5 * (1e-3 - 7e-4)}};

/// A linear displacement on the boundary of a distorted mesh: the same inside, one stress
/// everywhere.
template <class Element>
class PatchOf : public ::testing::Test {
protected:
  PatchOf() : body(distorted_rectangle<Element>(0.3, 0.2, 4, 4)) { hold_boundary(body, linear); }

  void expect_constant(const PlaneStress& exact) {
    const auto outcome = body.step(tight(), 1.0);
    ASSERT_TRUE(outcome.converged) << outcome.equilibrium_residual;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const Vector2 u = linear(body.mesh.point(n)[0], body.mesh.point(n)[1]);
      EXPECT_NEAR(body.displacement()[2 * std::size_t(n)], u[0], 1e-12 * 1e-3);
      EXPECT_NEAR(body.displacement()[2 * std::size_t(n) + 1], u[1], 1e-12 * 1e-3);
    }
    // stress() shows the pressure of the end of the step; creep has no volume.
    for (const PlaneStress& stress : body.stresses()) {
      EXPECT_LE(difference(stress, exact).norm(), 1e-12 * exact.norm());
    }
  }

  PlaneStress elastic(double thermal) const {
    PlaneStress stress;
    stress.add(2.0 * mu, strain.deviator());
    return stress.add_identity(bulk * (strain.trace() - 3.0 * thermal));
  }

  FixedBody<Element> body;
};

using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral>;
TYPED_TEST_SUITE(PatchOf, Families);

TYPED_TEST(PatchOf, Elastic) {
  this->body.set_material(young, poisson, 0.0, exponent);
  this->expect_constant(this->elastic(0.0));
}

TYPED_TEST(PatchOf, WithThermalStrain) {
  this->body.set_material(young, poisson, 0.0, exponent);
  std::fill(this->body.problem.thermal.begin(), this->body.problem.thermal.end(), -0.02);
  this->expect_constant(this->elastic(-0.02));
}

TYPED_TEST(PatchOf, WithCreep) {
  constexpr double kappa = 1e-38;
  this->body.set_material(young, poisson, kappa, exponent);
  std::fill(this->body.problem.thermal.begin(), this->body.problem.thermal.end(), -1e-3);
  // |s| by bisection, so that nothing of the return map checks itself.
  const double trial = 2.0 * mu * strain.deviator().norm();
  double low = 0.0, high = trial;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (middle + 2.0 * mu * kappa * std::pow(middle, 5.0) < trial ? low : high) = middle;
  }
  ASSERT_LT(low, 0.9 * trial) << "creep must matter here";

  PlaneStress exact;
  exact.add(low / strain.deviator().norm(), strain.deviator());
  exact.add_identity(bulk * (strain.trace() + 3e-3));
  this->expect_constant(exact);
}

/// Strain that carries no stress, equal to the strain itself, leaves none.
TYPED_TEST(PatchOf, WithInelasticStrain) {
  this->body.set_material(young, poisson, 0.0, exponent);
  PlaneStress half;
  half.add(0.5, strain);
  std::fill(this->body.problem.inelastic.begin(), this->body.problem.inelastic.end(), half);
  PlaneStress exact;
  exact.add(0.5, this->elastic(0.0));
  this->expect_constant(exact);
}

}  // namespace
}  // namespace dccast::mechanics
