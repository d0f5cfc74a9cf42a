#include "core/casting/findings/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

class Motion : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const Case casting = testing::small_casting(GetParam());
  const mesh::SlabMesh2D slab{casting.section};
  const mesh::Mesh2D& mesh = slab.mesh();
  const material::MechanicalProperties properties{casting.alloy};
  std::vector<char> solid = std::vector<char>(std::size_t(mesh.elements()), 1);
  std::vector<double> when_liquid;

  template <class Displacement>
  std::vector<double> displaced(const Displacement& by) const {
    std::vector<double> u;
    for (int n = 0; n < mesh.nodes(); ++n) {
      const auto [x, y] = by(mesh.point(n)[0], mesh.point(n)[1]);
      u.insert(u.end(), {x, y});
    }
    return u;
  }
  std::vector<double> turned(double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return displaced([=](double x, double y) {
      return std::pair{c * x - s * y - x, s * x + c * y - y};
    });
  }
  double slip(double temperature, const std::vector<double>& u) const {
    const std::vector<double> t(std::size_t(mesh.nodes()), temperature);
    return largest_slip(mesh, solid, u, t, properties, 649.0).value;
  }
};

/// Small strains see theta^2 / 2 of a rigid rotation; the polar angle sees all of it, at any size.
TEST_P(Motion, ARigidRotationIsFoundAsItIs) {
  for (double angle : {1e-6, 0.0199, 0.0201, -0.1, 0.7, -3.0}) {
    const auto u = turned(angle);
    for (int e = 0; e < mesh.elements(); ++e)
      EXPECT_NEAR(element_turn(mesh, e, u)[0], angle, 1e-12);
    when_liquid.clear();
    EXPECT_NEAR(largest_rotation(mesh, solid, u, mesh.elements(), when_liquid).value,
                std::abs(angle), 1e-12);
  }
}

TEST_P(Motion, StretchingTurnsNothing) {
  const auto u = displaced([](double x, double y) { return std::pair{0.2 * x, -0.1 * y}; });
  EXPECT_NEAR(largest_rotation(mesh, solid, u, mesh.elements(), when_liquid).value, 0.0, 1e-12);
}

/// Rotation of the melt does not count; only rotation after solidification does.
TEST_P(Motion, RotationCountsFromSolidification) {
  solid.assign(solid.size(), 0);
  EXPECT_EQ(largest_rotation(mesh, solid, turned(0.5), mesh.elements(), when_liquid).value, 0.0);
  solid[3] = 1;
  const auto found = largest_rotation(mesh, solid, turned(0.6), mesh.elements(), when_liquid);
  EXPECT_NEAR(found.value, 0.1, 1e-12);
  EXPECT_EQ(found.place, centroid(mesh, 3));
  solid[3] = 0;
  EXPECT_EQ(largest_rotation(mesh, solid, turned(0.7), mesh.elements(), when_liquid).value, 0.0);
}

/// From -3.1 to 3.1 rad is a rotation by 0.08 rad in the opposite direction.
TEST_P(Motion, TheShorterWayRoundCounts) {
  when_liquid.assign(std::size_t(mesh.elements()), -3.1);
  EXPECT_NEAR(largest_rotation(mesh, solid, turned(3.1), mesh.elements(), when_liquid).value,
              2.0 * 3.14159265358979 - 6.2, 1e-9);
}

TEST_P(Motion, TheRowThatStretchesIsNotJudged) {
  EXPECT_EQ(largest_rotation(mesh, solid, turned(0.5), 0, when_liquid).value, 0.0);
  EXPECT_EQ(when_liquid.size(), std::size_t(mesh.elements()));
  EXPECT_NEAR(largest_rotation(mesh, solid, turned(0.6), mesh.elements(), when_liquid).value, 0.1,
              1e-12);
}

TEST_P(Motion, ThermalContractionIsNoSlip) {
  const double strain = properties.thermal_stretch(400.0) - properties.thermal_stretch(649.0);
  ASSERT_LT(strain, -0.03);
  for (double share : {0.0, 0.5, 1.0}) {
    EXPECT_NEAR(slip(400.0, displaced([&](double x, double) {
                       return std::pair{share * strain * x, 0.0};
                     })),
                0.0, 1e-12);
  }
  EXPECT_NEAR(slip(400.0, displaced([&](double x, double) {
                     return std::pair{1.5 * strain * x, 0.0};
                   })),
              -0.5 * strain * 0.28, 1e-12);
}

TEST_P(Motion, ASlideOutwardsIsSlipAtOnce) {
  EXPECT_NEAR(slip(400.0, displaced([](double, double) {
                     return std::pair{5e-3, 0.0};
                   })),
              5e-3, 1e-15);
}

TEST_P(Motion, MeltOnTheBlockDoesNotSlip) {
  solid.assign(solid.size(), 0);
  EXPECT_EQ(slip(680.0, displaced([](double, double) { return std::pair{0.1, 0.0}; })), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Elements, Motion,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

}  // namespace
}  // namespace dccast::casting
