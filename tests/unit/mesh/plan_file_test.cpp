// The plan of a quarter slab from a file, and what is refused of it.
#include "core/mesh/plan_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/divided_mesh.hpp"
#include "core/mesh/gmsh_reader.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/support/drawn_plan.hpp"
#include "tests/support/quarter_section.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::mesh {
namespace {

using dccast::testing::draw_plan;
using dccast::testing::gmsh_text;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A quarter of a cross: an arm of 0.3 by 0.1 m, and a stem 0.1 m wide up to y = 0.2 m.
Base<3> cross() {
  return draw_plan({0, 0.1, 0.2, 0.3}, {0, 0.1, 0.2},
                   [](double x, double y) { return x < 0.1 || y < 0.1; });
}

class PlanFile : public ::testing::Test {
protected:
  /// Reads a plan from a text; empty if it was refused.
  std::optional<Base<3>> read(const std::string& text) {
    dccast::testing::write_text(text, folder_ / "plan.msh");
    faults_ = Faults{};
    return read_plan(spec_, faults_);
  }
  std::string message_of(const std::string& text) {
    if (read(text)) return "";
    EXPECT_EQ(faults_.list().size(), 1u) << faults_.summary();
    EXPECT_EQ(faults_.list()[0].field, "mesh.file");
    EXPECT_FALSE(faults_.list()[0].permitted.empty());
    EXPECT_FALSE(faults_.list()[0].remedy.empty());
    return faults_.list()[0].message;
  }

  TemporaryFolder folder_;
  Faults faults_;
  SectionSpec spec_ = [&] {
    SectionSpec spec = dccast::testing::quarter_section(
        ElementKind::q1_bending, {0.3, Curve(0.2), 0.06}, {3, 2, 3, 0.1, 0.1, 0.02});
    spec.file = folder_ / "plan.msh";
    spec.growth = true;
    return spec;
  }();
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto begin = text.find(from);
  EXPECT_NE(begin, std::string::npos) << from;
  return text.replace(begin, from.size(), to);
}

double area_of(const Base<3>& plan) {
  double twice = 0.0;
  for (std::size_t i = 0; i < plan.cell_node.size(); ++i) {
    const std::size_t next = i % 4 == 3 ? i - 3 : i + 1;
    const double* a = &plan.node[2 * std::size_t(plan.cell_node[i])];
    const double* b = &plan.node[2 * std::size_t(plan.cell_node[next])];
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * twice;
}

/// Length of the outline, and its outward area vector, which is zero for a closed outline.
struct Outline {
  double length = 0.0, x = 0.0, y = 0.0;
};
Outline outline_of(const Base<3>& plan) {
  Outline outline;
  for (const auto& wall : plan.walls) {
    for (const auto& piece : wall.pieces) {
      const auto [a, b] = ends_of(plan, piece);
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      outline.length += length;
      outline.x += length * wall.normal[0];
      outline.y += length * wall.normal[1];
    }
  }
  return outline;
}

TEST_F(PlanFile, IsThePlanThatWasWritten) {
  const Base<3> drawn = cross();
  const auto plan = read(gmsh_text(drawn));
  ASSERT_TRUE(plan) << faults_.summary();
  EXPECT_EQ(plan->node, drawn.node);
  EXPECT_EQ(plan->cell_node, drawn.cell_node);
  ASSERT_EQ(plan->walls.size(), drawn.walls.size());
  for (std::size_t w = 0; w < drawn.walls.size(); ++w) {
    EXPECT_EQ(plan->walls[w].name, drawn.walls[w].name);
    EXPECT_EQ(plan->walls[w].normal, drawn.walls[w].normal);
    EXPECT_EQ(plan->walls[w].pieces.size(), drawn.walls[w].pieces.size());
  }
}

/// Each wall has one normal: a group along a bent face becomes several.
TEST_F(PlanFile, DividesAGroupByDirection) {
  Base<3> drawn = draw_plan({0, 0.1, 0.2, 0.3}, {0, 0.1, 0.2}, [](double, double) { return true; });
  for (std::size_t n = 0; n < drawn.node.size(); n += 2)  // a chamfer from x = 0.2 m
    if (drawn.node[n] > 0.25 && drawn.node[n + 1] > 0.15) drawn.node[n + 1] = 0.15;
  const auto plan = read(gmsh_text(drawn));
  ASSERT_TRUE(plan) << faults_.summary();

  std::vector<std::string> names;
  for (const auto& wall : plan->walls) names.push_back(wall.name);
  EXPECT_THAT(names, ElementsAre("symmetry_x", "symmetry_y", "side_x", "side_y", "side_y_2"));
  EXPECT_EQ(plan->walls[3].pieces.size(), 2u);
  EXPECT_NEAR(plan->walls[4].normal[1] / plan->walls[4].normal[0], 2.0, 1e-12);
}

TEST_F(PlanFile, TurnsReversedCellsRound) {
  Base<3> drawn = cross();
  const std::string whole = gmsh_text(drawn);
  // The first cell the other way round.
  const auto reversed = read(replaced(whole, " 3 2 0 1 1 2 3 4\n", " 3 2 0 1 1 4 3 2\n"));
  ASSERT_TRUE(reversed) << faults_.summary();
  EXPECT_EQ(reversed->cell_node, drawn.cell_node);
}

TEST_F(PlanFile, LiesExactlyOnItsMiddlePlanes) {
  Base<3> drawn = cross();
  for (double& place : drawn.node)
    if (place == 0.0) place = 3e-8;
  const auto plan = read(gmsh_text(drawn));
  ASSERT_TRUE(plan) << faults_.summary();
  EXPECT_EQ(plan->node, cross().node);
}

/// Refinement keeps outline and area, and neighbouring cells share their new nodes.
TEST_F(PlanFile, DividesItsCells) {
  Base<3> drawn = cross();
  drawn.node[2 * 2] += 0.013;  // oblique cells at the inner corner
  const auto coarse = read(gmsh_text(drawn));
  ASSERT_TRUE(coarse) << faults_.summary();
  spec_.refinement = 3;
  const auto fine = read(gmsh_text(drawn));
  ASSERT_TRUE(fine) << faults_.summary();

  EXPECT_EQ(fine->cells(), 9 * coarse->cells());
  EXPECT_NEAR(area_of(*fine), area_of(*coarse), 1e-15);
  const Outline outline = outline_of(*fine);
  EXPECT_NEAR(outline.length, outline_of(*coarse).length, 1e-14);
  EXPECT_NEAR(outline.x, 0.0, 1e-14);
  EXPECT_NEAR(outline.y, 0.0, 1e-14);
  // Euler: nodes and cells of a simply connected plan make one more than sides.
  int rim = 0;
  for (const auto& wall : fine->walls) rim += static_cast<int>(wall.pieces.size());
  EXPECT_EQ(fine->nodes() + fine->cells() - (4 * fine->cells() + rim) / 2, 1);
}

/// The block sinks with the distance from the nearest face: fully in the middle of the arm, not at
/// the inner corner of the cross.
TEST_F(PlanFile, SinksIntoABowl) {
  spec_.bowl = {.depth = 0.02, .lip = 0.02, .wall = 0.04};
  const auto plan = read(gmsh_text(cross()));
  ASSERT_TRUE(plan) << faults_.summary();
  ASSERT_EQ(plan->depth.size(), std::size_t(plan->nodes()));
  for (int n = 0; n < plan->nodes(); ++n) {
    const double x = plan->node[2 * std::size_t(n)], y = plan->node[2 * std::size_t(n) + 1];
    const bool on_face = x > 0.25 || y > 0.15 || (x > 0.05 && y > 0.05);
    EXPECT_NEAR(plan->depth[std::size_t(n)], on_face ? 0.0 : 0.02, 1e-15) << x << ", " << y;
  }
}

/// Growth and merging need no more of a plan than its cells.
TEST_F(PlanFile, CarriesRowsThatGrow) {
  const auto plan = read(gmsh_text(cross()));
  ASSERT_TRUE(plan) << faults_.summary();
  SlabMesh3D slab(spec_, *plan);
  slab.grow_to(0.5);
  EXPECT_EQ(slab.cells_per_row(), cross().cells());
  EXPECT_EQ(slab.heat_mesh().elements(), slab.rows() * cross().cells());
  EXPECT_EQ(slab.level(), 0.5);
}

TEST_F(PlanFile, NamesWhatItCannotTake) {
  const std::string whole = gmsh_text(cross());
  EXPECT_EQ(message_of(replaced(whole, "symmetry_y", "side_below")), "has no group 'symmetry_y'");
  EXPECT_EQ(message_of(replaced(whole, "side_x", "mould")),
            "has the unknown physical group 'mould'");
  EXPECT_EQ(message_of(replaced(whole, "side_x", "bottom")),
            "has the unknown physical group 'bottom'");
  EXPECT_THAT(message_of(replaced(replaced(whole, "symmetry_x", "side_z"), "side_x", "symmetry_x")),
              HasSubstr("symmetry_x at x = 0.1 m"));
  EXPECT_THAT(message_of(replaced(whole, " 0 0\n2 ", " 0 0.5\n2 ")), HasSubstr("several heights"));

  // One line of the narrow face is missing.
  const std::string line = "\n6 1 2 3 1 ";
  EXPECT_THAT(message_of(replaced(whole, line, "\n6 1 2 0 1 ")),
              HasSubstr("has 1 outer side of cells without a group"));
}

TEST_F(PlanFile, RefusesAHangingNode) {
  // Two cells above one: the middle node of the lower side of the upper ones hangs.
  Base<3> drawn = draw_plan({0, 0.1, 0.2}, {0, 0.1, 0.2}, [](double, double) { return true; });
  Base<3> hanging;
  hanging.node = drawn.node;
  hanging.walls = drawn.walls;
  // Nodes by drawing: cell (0,0) has 0 1 2 3; (0,1) adds 4 5; (1,0) adds 6 7; (1,1) adds 8.
  hanging.cell_node = drawn.cell_node;
  hanging.node.insert(hanging.node.end(), {0.05, 0.1, 0.05, 0.2});  // 9 and 10
  const std::vector<int> upper(drawn.cell_node.begin() + 4, drawn.cell_node.begin() + 8);
  hanging.cell_node.erase(hanging.cell_node.begin() + 4, hanging.cell_node.begin() + 8);
  hanging.cell_node.insert(hanging.cell_node.end(), {upper[0], 9, 10, upper[3]});
  hanging.cell_node.insert(hanging.cell_node.end(), {9, upper[1], upper[2], 10});
  for (auto& wall : hanging.walls) wall.pieces.clear();
  hanging.walls[1].pieces = {{0, 0}, {1, 0}};
  hanging.walls[0].pieces = {{0, 3}, {3, 3}};
  hanging.walls[2].pieces = {{1, 1}, {2, 1}};
  hanging.walls[3].pieces = {{3, 2}, {4, 2}, {2, 2}};

  EXPECT_THAT(message_of(gmsh_text(hanging)),
              HasSubstr("at first at (0.05, 0.1) m: node 10 hangs in the side of a cell"));
}

TEST_F(PlanFile, RefusesCellsThatAreNoQuadrilateralsOrFolded) {
  const std::string whole = gmsh_text(cross());
  EXPECT_EQ(message_of(replaced(whole, " 3 2 0 1 1 2 3 4\n", " 2 2 0 1 1 2 3\n")),
            "has triangles and quadrilaterals");
  EXPECT_THAT(message_of(replaced(whole, " 3 2 0 1 1 2 3 4\n", " 3 2 0 1 1 3 2 4\n")),
              HasSubstr("folded or flat"));

  Base<3> outside = cross();
  outside.node[0] = -0.01;
  EXPECT_THAT(message_of(gmsh_text(outside)), HasSubstr("symmetry_x at x = -0.01 m"));
}

const std::string cube =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"bottom\"\n$EndPhysicalNames\n"
    "$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n"
    "$Elements\n2\n1 3 2 1 1 1 2 3 4\n2 5 2 9 1 1 2 3 4 5 6 7 8\n$EndElements\n";

TEST_F(PlanFile, FlatAndSolidMeshesSayWhichGrowthTheyNeed) {
  EXPECT_EQ(message_of(cube), "is a solid mesh, which has no rows that could grow");
  EXPECT_THAT(faults_.list()[0].remedy, HasSubstr("mesh.growth = false"));

  Faults faults;
  EXPECT_FALSE(parse_gmsh<3>(gmsh_text(cross()), "plan.msh", ElementKind::q1, faults));
  ASSERT_EQ(faults.list().size(), 1u);
  EXPECT_EQ(faults.list()[0].message, "is a flat mesh without a solid element");
  EXPECT_THAT(faults.list()[0].remedy, HasSubstr("mesh.growth = true"));
}

}  // namespace
}  // namespace dccast::mesh
