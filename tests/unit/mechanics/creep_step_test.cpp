#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double young = 4e10, poisson = 0.3, exponent = 6.0, kappa = 2e-42;
constexpr double mu = young / (2.0 * (1.0 + poisson));

/// The rate of convergence that three errors at dt, dt/2 and dt/4 show.
void expect_first_order(const std::array<double, 3>& error, double largest_last) {
  EXPECT_NEAR(std::log2(error[0] / error[1]), 1.0, 0.1);
  EXPECT_NEAR(std::log2(error[1] / error[2]), 1.0, 0.06);
  EXPECT_LE(error[2], largest_last);
}

template <class Element>
class CreepOf : public ::testing::Test {};
TYPED_TEST_SUITE(CreepOf, PlaneFamilies);

/// Held at a pure shear strain, the stress falls as |s|^(2-q) = |s0|^(2-q) + (q-2) 2 mu kappa t.
TYPED_TEST(CreepOf, RelaxationFollowsTheClosedForm) {
  constexpr double stretch = 1e-3, end = 4.0;
  std::array<double, 3> error{};
  for (int level = 0; level < 3; ++level) {
    FixedBody<TypeParam> body(small_distorted_box<TypeParam>());
    body.set_material(young, poisson, kappa, exponent);
    hold_boundary(body, [](double x, double y) { return Vector2{stretch * x, -stretch * y}; });
    const int steps = 40 << level;
    // The instantaneous elastic stress: a step too short for creep.
    ASSERT_TRUE(body.step(tight(1e-12), 1e-12).converged);
    for (int i = 0; i < steps; ++i) ASSERT_TRUE(body.step(tight(1e-12), end / steps).converged);
    const double start = 2.0 * mu * stretch * std::sqrt(2.0);
    const double exact =
        std::pow(std::pow(start, 2.0 - exponent) + (exponent - 2.0) * 2.0 * mu * kappa * end,
                 1.0 / (2.0 - exponent));
    ASSERT_LT(exact, 0.7 * start);
    error[std::size_t(level)] = std::abs(body.stress(0, 0).deviator().norm() / exact - 1.0);
  }
  expect_first_order(error, 5e-3);
}

struct PlaneCreep {
  double out_of_plane = poisson * 3e7;  ///< [Pa] elastic value
  double strain = 0.0;                  ///< [1] axial, creep and what the first component adds
};

/// Creep under a constant axial stress in plane strain: the stress out of the plane grows from
/// nu sigma to sigma / 2. Integrated by the classical Runge-Kutta formula.
PlaneCreep exact_creep(double stress, double end) {
  const auto rate = [&](double out) {
    const PlaneStress s = PlaneStress{{stress, 0.0, out, 0.0}}.deviator();
    const double factor = kappa * std::pow(s.norm(), exponent - 2.0);
    const double out_rate = -young * factor * s[2];
    return std::array{out_rate, -poisson / young * out_rate + factor * s[0]};
  };
  PlaneCreep state;
  state.out_of_plane = poisson * stress;
  state.strain = (1.0 - poisson * poisson) / young * stress;
  constexpr int steps = 20000;
  const double h = end / steps;
  for (int i = 0; i < steps; ++i) {
    const double out = state.out_of_plane;
    const auto k1 = rate(out), k2 = rate(out + 0.5 * h * k1[0]), k3 = rate(out + 0.5 * h * k2[0]),
               k4 = rate(out + h * k3[0]);
    state.out_of_plane += h / 6.0 * (k1[0] + 2.0 * k2[0] + 2.0 * k3[0] + k4[0]);
    state.strain += h / 6.0 * (k1[1] + 2.0 * k2[1] + 2.0 * k3[1] + k4[1]);
  }
  return state;
}

TYPED_TEST(CreepOf, CreepUnderALoadFollowsItsEquation) {
  constexpr double stress = 3e7, end = 240.0, width = 0.3;
  const PlaneCreep exact = exact_creep(stress, end);
  ASSERT_GT(exact.out_of_plane, 0.4 * stress);

  std::array<double, 3> error{}, strain_error{};
  for (int level = 0; level < 3; ++level) {
    FixedBody<TypeParam> body(small_distorted_box<TypeParam>());
    body.set_material(young, poisson, kappa, exponent);
    hold_low_end(body, 0);
    hold_low_end(body, 1);
    body.add_traction(mesh::PatchKind::side, [](double, double) { return Vector2{stress, 0.0}; });
    const int steps = 50 << level;
    ASSERT_TRUE(body.step(tight(1e-12), 1e-12).converged);
    for (int i = 0; i < steps; ++i) ASSERT_TRUE(body.step(tight(1e-12), end / steps).converged);
    const PlaneStress found = body.stress(0, 0);
    EXPECT_NEAR(found[0], stress, 1e-9 * stress);
    EXPECT_NEAR(found[1], 0.0, 1e-9 * stress);
    error[std::size_t(level)] = std::abs(found[2] / exact.out_of_plane - 1.0);
    const double stretch = body.displacement()[2 * 3] / width;  // the lower right corner
    strain_error[std::size_t(level)] = std::abs(stretch / exact.strain - 1.0);
  }
  expect_first_order(error, 2e-3);
  expect_first_order(strain_error, 2e-3);
}

}  // namespace
}  // namespace dccast::mechanics
