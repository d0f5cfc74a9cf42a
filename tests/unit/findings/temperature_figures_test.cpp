#include "core/casting/findings/shell.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

class TemperatureFigures : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const mesh::SlabMesh2D slab{testing::small_casting(GetParam()).section};
  const mesh::Mesh2D& mesh = slab.mesh();
};

TEST_P(TemperatureFigures, SideTemperatureIsLinearBetweenNodesAndConstantBeyond) {
  std::vector<double> t;
  for (int n = 0; n < mesh.nodes(); ++n)
    t.push_back(mesh.point(n)[1] * 1000.0 + (mesh.point(n)[0] < 0.28 ? 500.0 : 0.0));
  for (double height : {0.0, 0.004, 0.05, 0.0999, 0.1}) {
    EXPECT_NEAR(side_temperature(mesh, t, height), 1000.0 * height, 1e-10);
  }
  EXPECT_NEAR(side_temperature(mesh, t, -0.2), 0.0, 1e-12);
  EXPECT_NEAR(side_temperature(mesh, t, 0.2), 100.0, 1e-12);
}

TEST_P(TemperatureFigures, SumpReachesDownToTheIsotherm) {
  const auto depth = [&](auto&& field) {
    std::vector<double> t;
    for (int n = 0; n < mesh.nodes(); ++n) t.push_back(field(mesh.point(n)[1]));
    return sump_depth(mesh, t, 0.1, 649.0);
  };
  EXPECT_NEAR(depth([](double y) { return 549.0 + 2000.0 * y; }), 0.05, 1e-12);
  EXPECT_EQ(depth([](double) { return 680.0; }), 0.1) << "all liquid";
  EXPECT_EQ(depth([](double) { return 600.0; }), 0.0) << "all solid";
}

TEST_P(TemperatureFigures, TheSideFreezesAtItsIsotherm) {
  std::vector<double> t;
  for (int n = 0; n < mesh.nodes(); ++n) t.push_back(600.0 + 1000.0 * mesh.point(n)[1]);
  const auto rim = unfrozen_side(mesh, t, 649.0);
  EXPECT_NEAR(rim.value, 0.051, 1e-12);
  EXPECT_NEAR(rim.place[0], 0.28, 1e-12);

  std::ranges::fill(t, 680.0);
  EXPECT_NEAR(unfrozen_side(mesh, t, 649.0).value, 0.1, 1e-12) << "all liquid";
  std::ranges::fill(t, 500.0);
  EXPECT_EQ(unfrozen_side(mesh, t, 649.0).value, 0.0) << "frozen up to the level";
}

INSTANTIATE_TEST_SUITE_P(Elements, TemperatureFigures,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

class SolidTemperatureFigures : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  static mesh::SectionSpec quarter_slab() {
    mesh::SectionSpec spec = testing::small_casting(GetParam()).section;
    spec.kind = mesh::SectionKind::quarter_slab;
    spec.half_thickness = Curve(0.15);
    spec.layers = 3;
    spec.wide_side_cell = 0.02;
    return spec;
  }
  template <class Field>
  std::vector<double> at_nodes(Field&& field) const {
    std::vector<double> t;
    for (int n = 0; n < mesh.nodes(); ++n) {
      const double* x = mesh.point(n);
      t.push_back(field(x[0], x[1], x[2]));
    }
    return t;
  }

  const mesh::SlabMesh3D slab{quarter_slab()};
  const mesh::Mesh3D& mesh = slab.mesh();
};

/// Hottest where the narrow face meets the plane y = 0, whatever the middle of the slab is at.
TEST_P(SolidTemperatureFigures, TheHottestPlaceOfBothFacesCounts) {
  const auto t = at_nodes([](double x, double y, double z) {
    return 1000.0 * z + 300.0 * x - 100.0 * y + (x == 0.0 && y == 0.0 ? 500.0 : 0.0);
  });
  for (const double height : {0.0, 0.004, 0.05, 0.0999, 0.1})
    EXPECT_NEAR(side_temperature(mesh, t, height), 1000.0 * height + 300.0 * 0.28, 1e-10);
  EXPECT_NEAR(side_temperature(mesh, t, 0.2), 100.0 + 300.0 * 0.28, 1e-12) << "of the upper edge";
}

TEST_P(SolidTemperatureFigures, TheSumpIsThatOfTheMiddle) {
  const auto t = at_nodes([](double x, double y, double z) {
    return 549.0 + 2000.0 * z + (x > 0.0 || y > 0.0 ? 500.0 : 0.0);
  });
  EXPECT_NEAR(sump_depth(mesh, t, 0.1, 649.0), 0.05, 1e-12);
}

/// The isotherm falls along the wide face and is level on the narrow one.
TEST_P(SolidTemperatureFigures, TheSideFreezesAtItsMeanDepthAroundTheSlab) {
  const auto t = at_nodes(
      [](double x, double, double z) { return 649.0 + 1000.0 * (z - 0.05 - 0.02 * x / 0.28); });
  const double wide = 0.1 - 0.06, narrow = 0.1 - 0.07;
  EXPECT_NEAR(unfrozen_side(mesh, t, 649.0).value, (0.28 * wide + 0.15 * narrow) / 0.43, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Elements, SolidTemperatureFigures,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

}  // namespace
}  // namespace dccast::casting
