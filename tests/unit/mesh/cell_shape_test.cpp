#include "core/mesh/cell_shape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace dccast::mesh {
namespace {

/// The edges around the facets of a cell, each once.
std::set<std::set<int>> edges_of_facets(const CellShape& shape) {
  std::set<std::set<int>> edges;
  for (const auto& facet : shape.facets)
    for (std::size_t i = 0; i < facet.size(); ++i)
      edges.insert({facet[i], facet[(i + 1) % facet.size()]});
  return edges;
}

TEST(CellShape, EdgesAreThoseOfTheFacets) {
  for (const CellShape& shape : cell_shapes()) {
    if (shape.facets.empty()) continue;
    std::set<std::set<int>> edges;
    for (const auto& [a, b] : shape.edges) edges.insert({a, b});
    EXPECT_EQ(edges.size(), shape.edges.size()) << shape.plural;
    EXPECT_EQ(edges, edges_of_facets(shape)) << shape.plural;
  }
}

// Euler's formula for a polyhedron, and for the boundary of a polygon.
TEST(CellShape, NodesEdgesAndFacetsBelongTogether) {
  for (const CellShape& shape : cell_shapes()) {
    const auto nodes = static_cast<std::size_t>(shape.nodes);
    if (shape.dimension == 3) {
      EXPECT_EQ(nodes + shape.facets.size(), shape.edges.size() + 2) << shape.plural;
    } else if (shape.dimension == 2) {
      EXPECT_EQ(nodes, shape.facets.size()) << shape.plural;
    }
  }
}

// Two facets run through their common edge in opposite directions, as on every closed oriented
// surface.
TEST(CellShape, FacetsOfASolidAllTurnTheSameWay) {
  for (const CellShape& shape : cell_shapes()) {
    if (shape.dimension != 3) continue;
    std::set<std::pair<int, int>> directed;
    for (const auto& facet : shape.facets)
      for (std::size_t i = 0; i < facet.size(); ++i)
        EXPECT_TRUE(directed.emplace(facet[i], facet[(i + 1) % facet.size()]).second)
            << shape.plural;
    for (const auto& [a, b] : directed) EXPECT_TRUE(directed.contains({b, a})) << shape.plural;
  }
}

TEST(CellShape, IsFoundByNodesByElementAndByTheNumberInAFile) {
  EXPECT_STREQ(cell_shape(3, 8).plural, "hexahedra");
  EXPECT_EQ(&cell_shape(3, ElementKind::q1_bending), &cell_shape(3, 8));
  EXPECT_EQ(&cell_shape(2, ElementKind::p1), &cell_shape(2, 3));
  EXPECT_EQ(find_gmsh_shape(4), &cell_shape(3, 4));
  EXPECT_EQ(find_gmsh_shape(11), nullptr);
  EXPECT_THROW(cell_shape(3, 10), std::logic_error);
}

}  // namespace
}  // namespace dccast::mesh
