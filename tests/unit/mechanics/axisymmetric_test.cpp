#include <gtest/gtest.h>

#include "core/mechanics/constitutive.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double radius = 0.3, height = 0.2, young = 4e10, poisson = 0.45;
constexpr double mu = young / (2.0 * (1.0 + poisson));
constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson));

template <class Element>
class AxisymmetricBody : public ::testing::Test {
protected:
  AxisymmetricBody() : body(distorted_rectangle<Element>(radius, height, 4, 4)) {
    body.set_material(young, poisson, 0.0, 6.0);
    body.problem.dt = 1.0;
  }

  std::vector<double> field(const std::function<Vector2(double, double)>& u) const {
    std::vector<double> values;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const Vector2 at = u(body.mesh.point(n)[0], body.mesh.point(n)[1]);
      values.insert(values.end(), {at[0], at[1]});
    }
    return values;
  }
  std::vector<double> residual(const std::vector<double>& u) const {
    std::vector<double> r(u.size());
    Equilibrium equilibrium(body.problem);
    equilibrium.residual(u, r, return_map_law(body.problem));
    return r;
  }

  FixedBody<Element> body;
};
using Families =
    ::testing::Types<fem::AxisymmetricP1, fem::AxisymmetricQ1, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(AxisymmetricBody, Families);

/// A swelling a r stretches around as much as across; a shear strain comes with it.
TYPED_TEST(AxisymmetricBody, StrainIncludesTheHoop) {
  constexpr double across = 2e-3, along = -1e-3, shear = 4e-4;
  const auto u = this->field([](double r, double z) {
    return Vector2{across * r, along * z + 2.0 * shear * r};
  });
  const PlaneStress exact{{across, along, across, shear}};
  for (int e = 0; e < this->body.mesh.elements(); ++e) {
    for (std::size_t q = 0; q < TypeParam::points; ++q) {
      const auto strain = this->body.forms.strain(std::size_t(e), q, u);
      EXPECT_LE(difference(strain, exact).norm(),
                1e-14 * exact.norm() * this->body.mesh.elements());
    }
  }
}

/// Uniform strain with creep: one stress everywhere, a hoop stress with it, and inner nodes in
/// balance.
TYPED_TEST(AxisymmetricBody, PassesThePatchTestWithCreep) {
  constexpr double across = 2e-3, along = -1.5e-3, kappa = 1e-38;
  const auto linear = [](double r, double z) { return Vector2{across * r, along * z}; };
  this->body.set_material(young, poisson, kappa, 6.0);
  hold_boundary(this->body, linear);
  const auto outcome = this->body.step(tight(), 1.0);
  ASSERT_TRUE(outcome.converged) << outcome.equilibrium_residual;

  const auto exact = this->field(linear);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(this->body.displacement()[i], exact[i], 1e-15);
  }

  const PlaneStress strain{{across, along, across, 0.0}};
  const double trial = 2.0 * mu * strain.deviator().norm();
  for (const auto& s : this->body.unknowns().deviator) {
    const double norm = s.norm();
    EXPECT_LT(norm, 0.9 * trial) << "creep must matter here";
    EXPECT_NEAR(norm + 2.0 * mu * kappa * std::pow(norm, 5.0), trial, 1e-11 * trial);
    EXPECT_NEAR(s[2], s[0], 1e-11 * trial) << "hoop and radial";
  }
}

/// The pull on the rim of a swelling disc without axial stress, by hand: s_rr R h, per radian.
TYPED_TEST(AxisymmetricBody, ForcesArePerRadian) {
  constexpr double across = 1e-3;
  // s_zz = 0: e_zz = -2 nu / (1 - nu) e_rr, s_rr = E / (1 - nu) e_rr.
  const auto r = this->residual(this->field([](double x, double z) {
    return Vector2{across * x, -2.0 * poisson / (1.0 - poisson) * across * z};
  }));
  const double exact = young / (1.0 - poisson) * across * radius * height;
  double rim = 0.0, lid = 0.0, within = 0.0;
  for (int n = 0; n < this->body.mesh.nodes(); ++n) {
    const double* x = this->body.mesh.point(n);
    const double* f = &r[2 * std::size_t(n)];
    if (x[0] == radius)
      rim += f[0];
    else
      within = std::max(within, std::abs(f[0]));
    if (x[1] == height) lid += f[1];
  }

  EXPECT_NEAR(rim, exact, 1e-12 * exact);
  EXPECT_NEAR(lid, 0.0, 1e-12 * exact);
  EXPECT_NEAR(within, 0.0, 1e-12 * exact) << "the hoop stress balances the radial one";
}

TYPED_TEST(AxisymmetricBody, ARigidLiftLeavesNoForce) {
  for (double f : this->residual(this->field([](double, double) { return Vector2{0.0, 0.01}; }))) {
    EXPECT_LE(std::abs(f), 1e-14 * young * 0.01 * radius);
  }
}

/// Forces along the axis are in balance, whatever the displacement.
TYPED_TEST(AxisymmetricBody, AxialForcesAreInBalance) {
  const auto r = this->residual(this->field([](double x, double z) {
    return Vector2{1e-3 * x * std::sin(9.0 * z), 1e-3 * std::cos(7.0 * x + 5.0 * z)};
  }));
  double sum = 0.0, scale = 0.0;
  for (std::size_t i = 1; i < r.size(); i += 2) sum += r[i], scale += std::abs(r[i]);
  EXPECT_LE(std::abs(sum), 1e-13 * scale);
}

/// Free to expand in all directions, a billet warms or cools evenly without any stress; in plane
/// strain it would have one across the section.
TYPED_TEST(AxisymmetricBody, AFreeThermalExpansionLeavesNoStress) {
  constexpr double stretch = -0.02;
  for (double& thermal : this->body.problem.thermal) thermal = stretch;
  for (int n = 0; n < this->body.mesh.nodes(); ++n) {
    if (this->body.mesh.point(n)[0] == 0.0) this->body.fix(n, 0, 0.0);
    if (this->body.mesh.point(n)[1] == 0.0) this->body.fix(n, 1, 0.0);
  }
  const auto outcome = this->body.step(tight(1e-9), 1.0);
  ASSERT_TRUE(outcome.converged) << outcome.equilibrium_residual;

  const auto exact = this->field([](double r, double z) {
    return Vector2{stretch * r, stretch * z};
  });
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(this->body.displacement()[i], exact[i], 1e-14);
  }

  for (const auto& stress : this->body.stresses()) EXPECT_LE(stress.norm(), 1e-12 * bulk * 0.06);
}

}  // namespace
}  // namespace dccast::mechanics
