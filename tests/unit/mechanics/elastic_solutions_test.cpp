#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

/// Order of convergence seen between errors at h and h/2.
double order(double coarse, double fine) {
  return std::log2(coarse / fine);
}

template <class Element>
class SolutionOf : public ::testing::Test {};
TYPED_TEST_SUITE(SolutionOf, PlaneFamilies);

/// u = (A sin(pi x) cos(pi y), B cos(pi x) sin(pi y)) in the unit square, with the body force that
/// keeps it in balance and its values on the boundary: orders 2 and 1.
TYPED_TEST(SolutionOf, OrdersOfConvergenceAreTwoAndOne) {
  constexpr double pi = 3.14159265358979323846, a = 2e-3, b = -0.7e-3;
  constexpr double lambda = 3e10, mu = 2e10;
  const auto displacement = [](double x, double y) {
    return Vector2{a * std::sin(pi * x) * std::cos(pi * y),
                   b * std::cos(pi * x) * std::sin(pi * y)};
  };
  const auto stress = [](double x, double y) {
    const double cc = pi * std::cos(pi * x) * std::cos(pi * y);
    const double ss = pi * std::sin(pi * x) * std::sin(pi * y);
    const double volume = lambda * (a + b) * cc;
    return PlaneStress{
        {volume + 2.0 * mu * a * cc, volume + 2.0 * mu * b * cc, volume, -mu * (a + b) * ss}};
  };
  const auto force = [](double x, double y) {
    const double common = (lambda + mu) * (a + b);
    return Vector2{pi * pi * (common + 2.0 * mu * a) * std::sin(pi * x) * std::cos(pi * y),
                   pi * pi * (common + 2.0 * mu * b) * std::cos(pi * x) * std::sin(pi * y)};
  };
  std::array<verification::Errors, 3> error;
  for (int level = 0; level < 3; ++level) {
    const int cells = 8 << level;
    FixedBody<TypeParam> body(box<TypeParam>({1.0, 1.0}, {cells, cells}));
    std::fill(body.problem.bulk.begin(), body.problem.bulk.end(), lambda + 2.0 / 3.0 * mu);
    std::fill(body.problem.shear.begin(), body.problem.shear.end(), mu);
    hold_boundary(body, displacement);
    body.add_body_force(force);
    ASSERT_TRUE(body.step(tight(1e-12), 1.0).converged);
    error[std::size_t(level)] =
        verification::relative_errors<TypeParam>(body, displacement, stress);
  }

  EXPECT_NEAR(order(error[0].displacement, error[1].displacement), 2.0, 0.1);
  EXPECT_NEAR(order(error[1].displacement, error[2].displacement), 2.0, 0.03);
  EXPECT_NEAR(order(error[0].stress, error[1].stress), 1.0, 0.1);
  EXPECT_NEAR(order(error[1].stress, error[2].stress), 1.0, 0.03);
}

/// A free strip whose thermal strain is c y bows with the curvature (1 + nu) c and keeps no stress
/// in its plane; across it, held in plane strain, it carries -E c y.
template <class Element>
double error_of_bowed_strip(int rows) {
  constexpr double young = 6e10, poisson = 0.33, slope = 0.1, length = 1.0, height = 0.1;
  FixedBody<Element> body(box<Element>({length, height}, {10 * rows, rows}));
  body.set_material(young, poisson, 0.0, 2.0);
  for (int e = 0; e < body.mesh.elements(); ++e) {
    body.problem.thermal[std::size_t(e)] = slope * height_of(body.mesh, e);
  }
  hold_low_end(body, 0);
  body.fix(0, 1, 0.0);
  EXPECT_TRUE(body.step(tight(1e-10), 1.0).converged);
  const double curvature = (1.0 + poisson) * slope;
  return verification::relative_errors<Element>(
             body,
             [=](double x, double y) {
               return Vector2{curvature * x * y, 0.5 * curvature * (y * y - x * x)};
             },
             [=](double, double y) {
               return PlaneStress{{0.0, 0.0, -young * slope * y, 0.0}};
             })
      .displacement;
}

TEST(BowedStrip, BowsWithTheKnownCurvature) {
  const double triangles[] = {error_of_bowed_strip<fem::P1Triangle>(8),
                              error_of_bowed_strip<fem::P1Triangle>(16)};
  EXPECT_NEAR(order(triangles[0], triangles[1]), 2.0, 0.3);
  const double squares[] = {error_of_bowed_strip<fem::Q1Quadrilateral>(8),
                            error_of_bowed_strip<fem::Q1Quadrilateral>(16)};
  EXPECT_NEAR(order(squares[0], squares[1]), 2.0, 0.3);
  EXPECT_LE(squares[1], 1e-2);
}

/// Bending of a nearly incompressible strip by a traction c (y - h/2): relative error of the
/// deflection of the tip's middle, -c L^2 (1 - nu^2) / (2 E) from the clamped plane's.
template <class Element>
double error_of_bending(int rows) {
  constexpr double young = 1e9, poisson = 0.4999, length = 1.0, height = 0.25, slope = 1e6;
  FixedBody<Element> body(box<Element>({length, height}, {4 * rows, rows}));
  body.set_material(young, poisson, 0.0, 2.0);
  hold_low_end(body, 0);
  const int middle = rows / 2 * (4 * rows + 1);
  body.fix(middle, 1, 0.0);
  body.add_traction(mesh::PatchKind::side, [](double, double y) {
    return Vector2{slope * (y - 0.5 * height), 0.0};
  });
  EXPECT_TRUE(body.step(tight(1e-9), 1.0).converged);
  const double exact = -slope * length * length * (1.0 - poisson * poisson) / (2.0 * young);
  const double tip = body.displacement()[2 * std::size_t(middle + 4 * rows) + 1];
  return std::abs(tip / exact - 1.0);
}

/// numerics 3: triangles with one stress each lock; the mean dilatation does not.
TEST(NearlyIncompressible, MeanDilatationDoesNotLockWhereTrianglesDo) {
  const double squares[] = {error_of_bending<fem::Q1Quadrilateral>(4),
                            error_of_bending<fem::Q1Quadrilateral>(8)};
  EXPECT_LE(squares[1], 0.02);
  EXPECT_NEAR(order(squares[0], squares[1]), 2.0, 0.3);
  EXPECT_GE(error_of_bending<fem::P1Triangle>(8), 20.0 * squares[1]);
  EXPECT_LE(error_of_bending<fem::BendingQuadrilateral>(4), 1e-3) << "bends as it is";
}

}  // namespace
}  // namespace dccast::mechanics
