#include "core/casting/monitors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

class Monitors : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const mesh::SlabMesh2D slab{testing::small_casting(GetParam()).section};
  const mesh::Mesh2D& mesh = slab.mesh();
};

TEST_P(Monitors, InterpolateALinearFieldExactly) {
  std::vector<double> u;
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* x = mesh.point(n);
    u.insert(u.end(), {1.0 + 2.0 * x[0] - 3.0 * x[1], -0.5 + x[0] + 7.0 * x[1]});
  }
  for (int i = 0; i <= 20; ++i) {
    for (int j = 0; j <= 20; ++j) {
      const double x = 0.28 * i / 20.0, y = 0.10 * j / 20.0;
      const auto place = locate(mesh, x, y);
      ASSERT_TRUE(place) << x << ", " << y;
      const auto at = displacement_at(mesh, *place, u);
      EXPECT_NEAR(at[0], 1.0 + 2.0 * x - 3.0 * y, 1e-13);
      EXPECT_NEAR(at[1], -0.5 + x + 7.0 * y, 1e-13);
    }
  }
}

TEST_P(Monitors, ANodeIsFoundAsItself) {
  std::vector<double> u(2 * std::size_t(mesh.nodes()), 0.0);
  for (int n = 0; n < mesh.nodes(); ++n) {
    u[2 * std::size_t(n)] = 1.0;
    const auto place = locate(mesh, mesh.point(n)[0], mesh.point(n)[1]);
    ASSERT_TRUE(place);
    EXPECT_NEAR(displacement_at(mesh, *place, u)[0], 1.0, 1e-12);
    u[2 * std::size_t(n)] = 0.0;
  }
}

TEST_P(Monitors, NothingIsFoundOutside) {
  for (const auto& [x, y] :
       {std::pair{0.2801, 0.05}, {-0.0001, 0.05}, {0.1, 0.1001}, {0.1, -0.0001}}) {
    EXPECT_FALSE(locate(mesh, x, y)) << x << ", " << y;
  }
}

TEST_P(Monitors, SideTemperatureIsLinearBetweenNodesAndConstantBeyond) {
  std::vector<double> t;
  for (int n = 0; n < mesh.nodes(); ++n)
    t.push_back(mesh.point(n)[1] * 1000.0 + (mesh.point(n)[0] < 0.28 ? 500.0 : 0.0));
  for (double height : {0.0, 0.004, 0.05, 0.0999, 0.1}) {
    EXPECT_NEAR(side_temperature(mesh, t, height), 1000.0 * height, 1e-10);
  }
  EXPECT_NEAR(side_temperature(mesh, t, -0.2), 0.0, 1e-12);
  EXPECT_NEAR(side_temperature(mesh, t, 0.2), 100.0, 1e-12);
}

TEST_P(Monitors, SumpReachesDownToTheIsotherm) {
  const auto depth = [&](auto&& field) {
    std::vector<double> t;
    for (int n = 0; n < mesh.nodes(); ++n) t.push_back(field(mesh.point(n)[1]));
    return sump_depth(mesh, t, 0.1, 649.0);
  };
  EXPECT_NEAR(depth([](double y) { return 549.0 + 2000.0 * y; }), 0.05, 1e-12);
  EXPECT_EQ(depth([](double) { return 680.0; }), 0.1) << "all liquid";
  EXPECT_EQ(depth([](double) { return 600.0; }), 0.0) << "all solid";
}

INSTANTIATE_TEST_SUITE_P(Elements, Monitors,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

/// A quadrilateral that is no rectangle: the bilinear map is inverted by Newton.
TEST(Locate, FindsThePlaceInASkewedQuadrilateral) {
  mesh::Mesh2D skewed;
  skewed.node = {0.0, 0.0, 2.0, 0.3, 1.7, 1.9, -0.2, 1.1};
  skewed.nodes_per_element = 4;
  skewed.element_node = {0, 1, 2, 3};
  const auto place = locate(skewed, 0.9, 0.8);
  ASSERT_TRUE(place);
  const auto at = displacement_at(skewed, *place, skewed.node);
  EXPECT_NEAR(at[0], 0.9, 1e-12);
  EXPECT_NEAR(at[1], 0.8, 1e-12);
  EXPECT_FALSE(locate(skewed, 1.9, 1.0));
}

}  // namespace
}  // namespace dccast::casting
