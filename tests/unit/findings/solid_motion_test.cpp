// Rotation, slip and shell of a quarter slab; those of a section are in motion_test and shell_test.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/tensors.hpp"
#include "core/casting/findings/motion.hpp"
#include "core/casting/findings/shell.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using Vector = std::array<double, 3>;

/// Rodrigues' formula: a turn by an angle [rad] about a unit vector.
Matrix3 turn_about(const Vector& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Matrix3 m{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k) m[r][k] = (1.0 - c) * axis[r] * axis[k];
  for (std::size_t i = 0; i < 3; ++i) {
    m[i][i] += c;
    m[(i + 2) % 3][(i + 1) % 3] += s * axis[i];
    m[(i + 1) % 3][(i + 2) % 3] -= s * axis[i];
  }
  return m;
}

const Vector slanted{2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0};

class SolidMotion3D : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  static Case quarter_slab() {
    Case c = testing::small_casting(GetParam());
    c.section.kind = mesh::SectionKind::quarter_slab;
    c.section.half_thickness = Curve(0.15);
    c.section.layers = 3;
    c.section.wide_side_cell = 0.02;
    return c;
  }
  /// u = (m - 1) x
  std::vector<double> moved(const Matrix3& m) const {
    std::vector<double> u;
    for (int n = 0; n < mesh.nodes(); ++n) {
      const double* x = mesh.point(n);
      for (std::size_t r = 0; r < 3; ++r)
        u.push_back(m[r][0] * x[0] + m[r][1] * x[1] + m[r][2] * x[2] - x[r]);
    }
    return u;
  }
  double rotation(const std::vector<double>& u) {
    return largest_rotation(mesh, solid, u, mesh.elements(), when_liquid).value;
  }
  double slip(double temperature, const std::vector<double>& u) const {
    const std::vector<double> t(std::size_t(mesh.nodes()), temperature);
    return largest_slip(mesh, solid, u, t, properties, 649.0).value;
  }

  const Case casting = quarter_slab();
  const mesh::SlabMesh3D slab{casting.section};
  const mesh::Mesh3D& mesh = slab.mesh();
  const material::MechanicalProperties properties{casting.alloy};
  std::vector<char> solid = std::vector<char>(std::size_t(mesh.elements()), 1);
  std::vector<double> when_liquid;
};

TEST_P(SolidMotion3D, ARigidRotationIsFoundAsItIs) {
  for (const double angle : {1e-6, 0.1, 0.7, 2.0, 3.1}) {
    when_liquid.clear();
    EXPECT_NEAR(rotation(moved(turn_about(slanted, angle))), angle, 1e-11) << angle;
  }
}

TEST_P(SolidMotion3D, StretchingTurnsNothing) {
  const auto u = moved({{{1.2, 0, 0}, {0, 0.9, 0}, {0, 0, 1.05}}});
  EXPECT_NEAR(rotation(u), 0.0, 1e-12);
}

TEST_P(SolidMotion3D, AStretchBeforeARotationDoesNotChangeIt) {
  const Matrix3 stretch{{{1.2, 0.1, 0}, {0.1, 0.9, 0.05}, {0, 0.05, 1.05}}};
  EXPECT_NEAR(rotation(moved(product(turn_about(slanted, 0.4), stretch))), 0.4, 1e-11);
}

/// The two rotations are about different axes: what counts is the one that leads from one to the
/// other.
TEST_P(SolidMotion3D, RotationCountsFromSolidification) {
  const Matrix3 before = turn_about(slanted, 0.5);
  solid.assign(solid.size(), 0);
  EXPECT_EQ(rotation(moved(before)), 0.0);
  solid[3] = 1;
  const auto u = moved(product(turn_about({0, 1, 0}, 0.1), before));
  const auto found = largest_rotation(mesh, solid, u, mesh.elements(), when_liquid);
  EXPECT_NEAR(found.value, 0.1, 1e-11);
  EXPECT_EQ(found.place, centroid(mesh, 3));
}

TEST_P(SolidMotion3D, ThermalContractionIsNoSlip) {
  const double strain = properties.thermal_stretch(400.0) - properties.thermal_stretch(649.0);
  const auto shrunk = [&](double x, double y) {
    return moved({{{1.0 + x * strain, 0, 0}, {0, 1.0 + y * strain, 0}, {0, 0, 1}}});
  };
  for (const double share : {0.0, 0.5, 1.0})
    EXPECT_NEAR(slip(400.0, shrunk(share, share)), 0, 1e-12);
  EXPECT_NEAR(slip(400.0, shrunk(1.5, 1.0)), -0.5 * strain * 0.28, 1e-12);
  EXPECT_NEAR(slip(400.0, shrunk(1.0, 1.5)), -0.5 * strain * 0.15, 1e-12);
  EXPECT_NEAR(slip(400.0, shrunk(1.0, -0.1)), -0.1 * strain * 0.15, 1e-12) << "outwards";
}

/// One molten row over the block but for a column of solid: thinnest beside it, thicker on it.
TEST_P(SolidMotion3D, TheShellIsAsThickAsItsThinnestPlace) {
  const int per_row = slab.elements_per_row();
  const double first = slab.row_heights()[1], second = slab.row_heights()[2];
  const auto molten_from = [&](int row) {
    for (int e = 0; e < mesh.elements(); ++e) solid[std::size_t(e)] = e < row * per_row;
  };
  molten_from(2);
  EXPECT_NEAR(thinnest_shell(mesh, solid)->value, second, 1e-12);

  const int per_cell = per_row / slab.cells_per_row();
  for (int i = 0; i < per_cell; ++i) solid[std::size_t(per_row + 4 * per_cell + i)] = 0;
  EXPECT_NEAR(thinnest_shell(mesh, solid)->value, first, 1e-12) << "over that cell";
  EXPECT_FALSE(melt_touches_bottom(mesh, solid));

  for (int i = 0; i < per_cell; ++i) solid[std::size_t(4 * per_cell + i)] = 0;
  EXPECT_TRUE(melt_touches_bottom(mesh, solid));
  EXPECT_EQ(thinnest_shell(mesh, solid)->value, 0.0);
  EXPECT_EQ(thinnest_shell(mesh, solid)->place.size(), 3u);
}

INSTANTIATE_TEST_SUITE_P(Elements, SolidMotion3D,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

TEST(PolarRotation, OfAVolumeTurnedInsideOutIsNone) {
  EXPECT_EQ(polar_rotation({{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}})[2][2], 1.0);
}

}  // namespace
}  // namespace dccast::casting
