#include "core/mechanics/element_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

mesh::Mesh3D cube(const Cells<3>& cells) {
  return box<fem::Q1Hexahedron>({1.0, 1.0, 1.0}, cells);
}

std::set<int> nodes_of(const mesh::Mesh<3>& mesh, std::size_t first_block, std::size_t end_block) {
  std::set<int> nodes;
  const std::size_t end = std::min(end_block * elements_in_block, std::size_t(mesh.elements()));
  for (std::size_t e = first_block * elements_in_block; e < end; ++e) {
    const int* node = mesh.nodes_of(static_cast<int>(e));
    nodes.insert(node, node + mesh.nodes_per_element);
  }
  return nodes;
}

TEST(ElementParts, CoverTheMeshAndShareNoNodeWithTheirOwnColour) {
  const mesh::Mesh<3> mesh = cube({8, 5, 20});
  const ElementParts parts = ElementParts::of(mesh);
  ASSERT_GE(parts.parts(), 4u);

  std::vector<std::set<int>> nodes(parts.parts());
  std::vector<std::pair<std::size_t, std::size_t>> blocks(parts.parts());
  parts.for_each([&](std::size_t part, std::size_t first, std::size_t end) {
    nodes[part] = nodes_of(mesh, first, end);
    blocks[part] = {first, end};
  });
  for (std::size_t p = 0; p < nodes.size(); ++p) {
    EXPECT_EQ(blocks[p].first, p == 0 ? 0 : blocks[p - 1].second);
    for (std::size_t other = p + 2; other < nodes.size(); other += 2) {
      std::vector<int> common;
      std::ranges::set_intersection(nodes[p], nodes[other], std::back_inserter(common));
      EXPECT_TRUE(common.empty()) << p << " and " << other;
    }
  }
  EXPECT_GE(blocks.back().second * elements_in_block, std::size_t(mesh.elements()));
}

TEST(ElementParts, AreOneWhereElementsAreFewOrNumberedInNoDirection) {
  EXPECT_EQ(ElementParts::of(cube({2, 2, 2})).parts(), 1u);
  mesh::Mesh<3> mesh = cube({8, 5, 20});
  for (std::size_t e = 0; e < std::size_t(mesh.elements()); ++e) {
    const std::size_t other = 37 * e % std::size_t(mesh.elements());
    for (std::size_t i = 0; i < 8; ++i)
      std::swap(mesh.element_node[8 * e + i], mesh.element_node[8 * other + i]);
  }
  EXPECT_EQ(ElementParts::of(mesh).parts(), 1u);
}

/// Residual and tangent of a body with creep, in parts by a team and in parts by one thread.
TEST(ElementParts, GiveATeamTheBitsOfOneThread) {
  FixedBody<fem::BendingHexahedron> body(
      distorted_box<fem::BendingHexahedron>({0.3, 0.2, 0.5}, {8, 5, 12}));
  body.set_material(4e10, 0.3);
  for (double& kappa : body.problem.kappa) kappa = 1e-38;
  const ElementParts parts = ElementParts::of(body.mesh);
  ASSERT_GT(parts.parts(), 1u);

  body.problem.parts = &parts;
  std::vector<double> u(body.problem.unknowns());
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = 1e-4 * std::sin(1.7 * double(i));
  const auto found = [&] {
    Equilibrium<3> equilibrium(body.problem);
    std::vector<double> force(u.size()), stiffness(body.problem.pattern->entries());
    const double acting = equilibrium.residual(u, force, return_map_law(body.problem));
    equilibrium.tangent(stiffness);
    return std::tuple(acting, force, stiffness);
  };
  const auto alone = found();
  Team team(2);
  const Team::Lent lent(&team);
  for (int repeat = 0; repeat < 10; ++repeat) EXPECT_EQ(found(), alone);
}

}  // namespace
}  // namespace dccast::mechanics
