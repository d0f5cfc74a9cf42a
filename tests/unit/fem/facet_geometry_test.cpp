#include "core/fem/facet_pieces.hpp"

#include <gtest/gtest.h>

namespace dccast::fem {
namespace {

template <int Dim>
mesh::Facet<Dim> facet_of(int nodes) {
  mesh::Facet<Dim> facet;
  facet.nodes = nodes;
  for (int i = 0; i < nodes; ++i) facet.node[std::size_t(i)] = i;
  return facet;
}
template <int Dim>
mesh::Mesh<Dim> nodes_at(std::vector<double> node) {
  mesh::Mesh<Dim> mesh;
  mesh.node = std::move(node);
  return mesh;
}

/// The bottom of a billet from its axis: shares that add up to its area by radian.
TEST(FacetShares, OfAnEdgeAddUpToTheArea) {
  const auto mesh = nodes_at<2>({0.1, 0.0, 0.5, 0.3});
  const auto flat = facet_shares_of<Q1Quadrilateral>(mesh, facet_of<2>(2));
  EXPECT_DOUBLE_EQ(flat[0], 0.25);
  EXPECT_DOUBLE_EQ(flat[1], 0.25);
  const auto shares = facet_shares_of<AxisymmetricQ1>(mesh, facet_of<2>(2));
  EXPECT_DOUBLE_EQ(shares[0] + shares[1], 0.5 * 0.3);  // length times mean radius
  EXPECT_DOUBLE_EQ(shares[1] - shares[0], 0.5 * 0.4 / 6.0);
}

TEST(FacetShares, OfATriangleAreThirdsOfItsArea) {
  const auto mesh = nodes_at<3>({1, 0, 2, 4, 0, 2, 1, 2, 4});  // legs 3 and the root of 8
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(facet_shares_of<P1Tetrahedron>(mesh, facet_of<3>(3))[i], std::sqrt(8.0) / 2);
  }
}

/// A trapezium with its parallel sides 3 and 1, 2 apart: linear functions have exact integrals.
TEST(FacetShares, OfAQuadrilateralIntegrateLinearFunctionsExactly) {
  const auto mesh = nodes_at<3>({0, 0, 0, 3, 0, 0, 2, 0, 2, 1, 0, 2});
  const auto shares = facet_shares_of<BendingHexahedron>(mesh, facet_of<3>(4));
  double area = 0.0, of_x = 0.0, of_z = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    area += shares[i];
    of_x += shares[i] * mesh.point(int(i))[0];
    of_z += shares[i] * mesh.point(int(i))[2];
  }
  EXPECT_DOUBLE_EQ(area, 4.0);
  EXPECT_DOUBLE_EQ(of_x, 4.0 * 1.5);
  EXPECT_DOUBLE_EQ(of_z, 2.0 * 2.0 / 2.0 * 3.0 - (3.0 - 1.0) / 2.0 * 8.0 / 3.0);
}

/// z = h x y over the unit square: its shares add up to the area to the quadrature's error.
TEST(FacetShares, OfAWarpedQuadrilateralAddUpToItsArea) {
  constexpr double h = 0.5;
  const auto mesh = nodes_at<3>({0, 0, 0, 1, 0, 0, 1, 1, h, 0, 1, 0});
  double exact = 0.0;
  constexpr int n = 400;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double x = (i + 0.5) / n, y = (j + 0.5) / n;
      exact += std::sqrt(1.0 + h * h * (x * x + y * y)) / (n * n);
    }
  }
  double area = 0.0;
  for (const double share : facet_shares(mesh, facet_of<3>(4))) area += share;
  EXPECT_NEAR(area, exact, 2e-4);
}

}  // namespace
}  // namespace dccast::fem
