#include <gtest/gtest.h>

#include "tests/unit/mechanics_solid/solid_body.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double young = 4e10, poisson = 0.45, exponent = 6.0;
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson));
constexpr double gradient[3][3] = {
    {2e-3, -7e-4, 4e-4}, {1e-3, -1.5e-3, 9e-4}, {-6e-4, 3e-4, 1.2e-3}};

Vector3 linear(const Vector3& x) {
  Vector3 u{1e-4, -3e-4, 2e-4};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) u[a] += gradient[a][b] * x[b];
  }
  return u;
}
SymmetricTensor<3> strain() {
  SymmetricTensor<3> e;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = a; b < 3; ++b) {
      e[e.index(a, b)] = 0.5 * (gradient[a][b] + gradient[b][a]);
    }
  }
  return e;
}

/// A linear displacement on the boundary of a distorted mesh, turned in space: the same inside, one
/// stress everywhere.
template <class Element>
class SolidPatchOf : public ::testing::Test {
protected:
  static BoxMesh shape() {
    BoxMesh box = distorted_box({0.3, 0.2, 0.4}, {3, 3, 4}, of_tetrahedra<Element>);
    for (std::size_t i = 0; i < box.mesh.node.size(); i += 3) {
      double* x = &box.mesh.node[i];
      const Vector3 y = turned({x[0], x[1], x[2]});
      std::copy(y.begin(), y.end(), x);
    }
    return box;
  }
  SolidPatchOf() : body(shape()) { body.hold_boundary(linear); }

  void expect_constant(const SymmetricTensor<3>& exact) {
    const auto outcome = body.step(in_balance());
    ASSERT_TRUE(outcome.converged) << outcome.equilibrium_residual;
    for (int n = 0; n < body.box.mesh.nodes(); ++n) {
      const Vector3 u = linear(body.place(n));
      for (int d = 0; d < 3; ++d) {
        EXPECT_NEAR(body.displacement(n, d), u[std::size_t(d)], 1e-12 * 1e-3);
      }
    }
    for (auto stress : body.stresses()) {
      EXPECT_LE(stress.add(-1.0, exact).norm(), 1e-11 * exact.norm());
    }
  }

  SymmetricTensor<3> elastic(double thermal) const {
    SymmetricTensor<3> stress;
    stress.add(2.0 * mu, strain().deviator());
    return stress.add_identity(bulk * (strain().trace() - 3.0 * thermal));
  }

  SolidBody<Element> body;
};

using Families = ::testing::Types<fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(SolidPatchOf, Families);

TYPED_TEST(SolidPatchOf, ElasticWithThermalStrain) {
  this->body.set_material(young, poisson);
  std::fill(this->body.problem.thermal.begin(), this->body.problem.thermal.end(), -0.02);
  this->expect_constant(this->elastic(-0.02));
}

TYPED_TEST(SolidPatchOf, NearlyIncompressible) {
  constexpr double almost_half = 0.4999;
  this->body.set_material(young, almost_half);
  SymmetricTensor<3> exact;
  exact.add(young / (1.0 + almost_half), strain().deviator());
  exact.add_identity(young / (3.0 * (1.0 - 2.0 * almost_half)) * strain().trace());
  this->expect_constant(exact);
}

TYPED_TEST(SolidPatchOf, WithCreep) {
  constexpr double kappa = 1e-38;
  this->body.set_material(young, poisson, kappa, exponent);
  // |s| by bisection, so that nothing of the return map checks itself.
  const double trial = 2.0 * mu * strain().deviator().norm();
  double low = 0.0, high = trial;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (middle + 2.0 * mu * kappa * std::pow(middle, 5.0) < trial ? low : high) = middle;
  }
  ASSERT_LT(low, 0.9 * trial) << "creep must matter here";

  SymmetricTensor<3> exact;
  exact.add(low / strain().deviator().norm(), strain().deviator());
  exact.add_identity(bulk * strain().trace());
  this->expect_constant(exact);
}

/// Strain that carries no stress, half of the strain itself, leaves half of the stress.
TYPED_TEST(SolidPatchOf, WithInelasticStrain) {
  this->body.set_material(young, poisson);
  SymmetricTensor<3> half, exact;
  half.add(0.5, strain());
  exact.add(0.5, this->elastic(0.0));
  std::fill(this->body.problem.inelastic.begin(), this->body.problem.inelastic.end(), half);
  this->expect_constant(exact);
}

}  // namespace
}  // namespace dccast::mechanics
