#include "core/fem/facet_pieces.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/fem/jacobian.hpp"

namespace dccast::fem {
namespace {

using Point = std::array<double, 3>;

mesh::Mesh<3> of_points(const std::vector<Point>& points) {
  mesh::Mesh<3> mesh;
  for (const Point& p : points) mesh.node.insert(mesh.node.end(), p.begin(), p.end());
  return mesh;
}

mesh::Facet<3> facet(int nodes) {
  mesh::Facet<3> f;
  f.nodes = nodes;
  std::iota(f.node.begin(), f.node.end(), 0);
  return f;
}

/// Pieces of a facet cut by height, from below.
std::vector<FacePiece> pieces_by_height(const std::vector<Point>& points,
                                        const std::vector<double>& levels) {
  const mesh::Mesh<3> mesh = of_points(points);
  std::array<double, 4> height{};
  for (std::size_t i = 0; i < points.size(); ++i) height[i] = points[i][2];
  std::vector<FacePiece> pieces;
  FaceCut(mesh, facet(static_cast<int>(points.size())), height)
      .for_each_piece(levels, [&](const FacePiece& piece) { pieces.push_back(piece); });
  return pieces;
}

double sum(const std::array<double, 4>& weight) {
  return std::accumulate(weight.begin(), weight.end(), 0.0);
}

/// First moment of the height over a piece, by its shape functions at the nodes' heights.
double moment(const FacePiece& piece, const std::vector<Point>& points) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) sum += piece.weight[i] * points[i][2];
  return sum;
}

const std::vector<Point> triangle{{0, 0, 0}, {3, 0, 0}, {0, 4, 2}};
const std::vector<Point> upright{{0, 1, 0.5}, {4, 4, 0.5}, {4, 4, 2.5}, {0, 1, 2.5}};
/// A plane trapezium in an upright plane: 4 wide below, 2 above.
const std::vector<Point> trapezium{{0, 0, 0}, {4, 0, 0}, {3, 0, 2}, {1, 0, 2}};
const std::vector<Point> warped{{0, 0, 0}, {2, 0.3, 0.1}, {2.2, 0, 2}, {-0.1, 0.2, 1.8}};

TEST(FaceCut, ATriangleIsCutByItsHeightExactly) {
  // Similar triangles: above a share h of the height the area falls as (1 - h)^2.
  const double area = 0.5 * 3.0 * std::hypot(4.0, 2.0);
  const auto pieces = pieces_by_height(triangle, {0.5, 1.5});
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_NEAR(pieces[0].area, area * (1.0 - 0.75 * 0.75), 1e-14);
  EXPECT_NEAR(pieces[1].area, area * (0.75 * 0.75 - 0.25 * 0.25), 1e-14);
  EXPECT_NEAR(pieces[2].area, area * 0.25 * 0.25, 1e-14);
  for (const FacePiece& piece : pieces) {
    EXPECT_NEAR(sum(piece.weight), piece.area, 1e-14);
    EXPECT_NEAR(moment(piece, triangle), piece.area * piece.middle_level, 1e-14);
  }
}

TEST(FaceCut, AnUprightRectangleIsCutInTrueBands) {
  const std::vector<double> levels{0.7, 1.1, 2.0}, edges{0.5, 0.7, 1.1, 2.0, 2.5};
  const auto pieces = pieces_by_height(upright, levels);
  ASSERT_EQ(pieces.size(), 4U);

  for (std::size_t k = 0; k < 4; ++k) {
    const double low = edges[k], high = edges[k + 1];
    EXPECT_NEAR(pieces[k].area, 5.0 * (high - low), 1e-14);
    EXPECT_NEAR(pieces[k].middle_level, 0.5 * (low + high), 1e-14);
    EXPECT_NEAR(moment(pieces[k], upright), 2.5 * (high * high - low * low), 1e-13);
    // Mean height under the shape function of the upper nodes: centroid of a trapezium.
    const auto power = [&](double n) {
      return (std::pow(high, n + 1) - std::pow(low, n + 1)) / (n + 1);
    };
    const double first = power(1) - 0.5 * power(0), second = power(2) - 0.5 * power(1);
    EXPECT_NEAR(pieces[k].level[2], second / first, 1e-13);
  }
}

/// Whatever the facet and the levels: the pieces make up the facet, node by node. The area of a
/// warped one is no polynomial: quadrature over other pieces differs by its error.
TEST(FaceCut, PiecesMakeUpTheFacet) {
  for (const auto& points : {triangle, upright, trapezium, warped}) {
    const auto whole = pieces_by_height(points, {});
    ASSERT_EQ(whole.size(), 1U);
    for (const auto& levels : {std::vector<double>{0.6}, {0.2, 0.2, 1.7}, {-1.0, 0.05, 0.9, 5.0}}) {
      std::array<double, 4> weight{};
      for (const FacePiece& piece : pieces_by_height(points, levels)) {
        for (std::size_t i = 0; i < 4; ++i) weight[i] += piece.weight[i];
      }
      const double error = points == warped ? 1e-6 : 1e-13;
      for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(weight[i], whole[0].weight[i], error);
    }
  }
  EXPECT_NEAR(pieces_by_height(trapezium, {})[0].area, 6.0, 1e-14);
}

TEST(FaceCut, ChangesContinuouslyWhereALevelPassesANode) {
  const auto below = pieces_by_height(warped, {1.8 - 1e-12}),
             above = pieces_by_height(warped, {1.8 + 1e-12});
  ASSERT_EQ(below.size(), above.size());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(below[0].weight[i], above[0].weight[i], 1e-11);
}

TEST(EdgeCut, PiecesAreExactWithARadius) {
  // From height 1 and radius 2 to height 3 and radius 4; between 1.5 and 2.5.
  const EdgeCut edge(2.0, {1.0, 3.0}, {2.0, 4.0});
  std::vector<EdgePiece> pieces;
  edge.for_each_piece(std::vector<double>{1.5, 2.5},
                      [&](const EdgePiece& p) { pieces.push_back(p); });
  ASSERT_EQ(pieces.size(), 3U);
  // Upper node: integral of xi (2 + 2 xi) 2 dxi over 0.25 to 0.75.
  const double exact =
      2.0 * (0.75 * 0.75 - 0.25 * 0.25) + 4.0 / 3.0 * (0.75 * 0.75 * 0.75 - 0.25 * 0.25 * 0.25);
  EXPECT_NEAR(pieces[1].weight[1][0] + pieces[1].weight[1][1], exact, 1e-14);
  EXPECT_NEAR(pieces[1].middle_level, 2.0, 1e-15);
}

/// The gradient of a linear function is its slope at every point of an oblique element.
template <class Element>
void expect_exact_gradient(const mesh::Mesh<Element::dimension>& mesh) {
  constexpr std::size_t dim = Element::dimension;
  std::vector<int> node(Element::nodes);
  std::iota(node.begin(), node.end(), 0);
  const std::array<double, 3> slope{2.0, -3.0, 5.0};
  for (const auto& corner : reference_corners<Element>()) {
    const auto reference = Element::shape_gradient(corner);
    const Jacobian<Element::dimension> jacobian(mesh, node.data(), reference);
    std::array<double, dim> gradient{};
    for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
      double value = 0.0;
      for (std::size_t a = 0; a < dim; ++a) value += slope[a] * mesh.point(node[i])[a];
      const auto g = jacobian.gradient(reference[i], 1.0 / jacobian.determinant());
      for (std::size_t a = 0; a < dim; ++a) gradient[a] += value * g[a];
    }
    for (std::size_t a = 0; a < dim; ++a) EXPECT_NEAR(gradient[a], slope[a], 1e-13);
  }
}

TEST(Jacobian, DifferentiatesExactly) {
  expect_exact_gradient<Q1Hexahedron>(of_points({{0, 0, 0},
                                                 {1.2, 0, 0.1},
                                                 {1, 1.1, 0},
                                                 {0, 1, 0.2},
                                                 {0.1, 0, 1},
                                                 {1, 0.2, 1},
                                                 {1.1, 1, 1.3},
                                                 {0, 1, 1}}));
  expect_exact_gradient<P1Tetrahedron>(
      of_points({{0, 0, 0}, {1, 0.1, 0}, {0.2, 1, 0}, {0.1, 0.3, 2}}));

  mesh::Mesh<2> plane;
  plane.node = {0, 0, 1, 0.2, 1.3, 1, 0.1, 0.9};
  expect_exact_gradient<Q1Quadrilateral>(plane);
}

}  // namespace
}  // namespace dccast::fem
