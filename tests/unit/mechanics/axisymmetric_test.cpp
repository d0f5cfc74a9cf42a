#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double radius = 0.3, height = 0.2, young = 4e10, poisson = 0.45;

template <class Element>
class AxisymmetricBody : public ::testing::Test {
protected:
  AxisymmetricBody() : body(distorted_box<Element>({radius, height}, {4, 4})) {
    body.set_material(young, poisson);
  }

  std::vector<double> field(const std::function<Vector2(double, double)>& u) const {
    std::vector<double> values;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      const Vector2 at = u(body.mesh.point(n)[0], body.mesh.point(n)[1]);
      values.insert(values.end(), {at[0], at[1]});
    }
    return values;
  }
  FixedBody<Element> body;
};
TYPED_TEST_SUITE(AxisymmetricBody, RoundFamilies);

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

/// The pull on the rim of a swelling disc without axial stress, by hand: s_rr R h, per radian.
TYPED_TEST(AxisymmetricBody, ForcesArePerRadian) {
  constexpr double across = 1e-3;
  // s_zz = 0: e_zz = -2 nu / (1 - nu) e_rr, s_rr = E / (1 - nu) e_rr.
  const auto r = this->body.residual(this->field([](double x, double z) {
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
  for (double f : this->body.residual(this->field([](double, double) {
         return Vector2{0.0, 0.01};
       }))) {
    EXPECT_LE(std::abs(f), 1e-14 * young * 0.01 * radius);
  }
}

/// Forces along the axis are in balance, whatever the displacement.
TYPED_TEST(AxisymmetricBody, AxialForcesAreInBalance) {
  const auto r = this->body.residual(this->field([](double x, double z) {
    return Vector2{1e-3 * x * std::sin(9.0 * z), 1e-3 * std::cos(7.0 * x + 5.0 * z)};
  }));
  double sum = 0.0, scale = 0.0;
  for (std::size_t i = 1; i < r.size(); i += 2) sum += r[i], scale += std::abs(r[i]);
  EXPECT_LE(std::abs(sum), 1e-13 * scale);
}

}  // namespace
}  // namespace dccast::mechanics
