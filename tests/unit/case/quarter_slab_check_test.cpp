// Faults for which a quarter-slab case is rejected.
#include <gtest/gtest.h>

#include <functional>
#include <ostream>

#include "core/mesh/base.hpp"
#include "tests/support/drawn_plan.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::small_casting;
using testing::small_quarter_slab;

struct Mistake {
  const char* name;
  const char* field;
  std::function<void(Case&)> make;
};
void PrintTo(const Mistake& m, std::ostream* out) {
  *out << m.name;
}

/// A sound case with a mistake has this one fault, which says what is permitted and the remedy.
void expect_one_fault(Case c, const Mistake& mistake) {
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  mistake.make(c);
  const CheckedCase checked = check(c);
  ASSERT_EQ(checked.faults.list().size(), 1u) << testing::all(checked.faults);
  const Fault& fault = checked.faults.list().front();
  EXPECT_EQ(fault.field, mistake.field) << fault.message;
  EXPECT_FALSE(fault.message.empty());
  EXPECT_FALSE(fault.permitted.empty());
  EXPECT_FALSE(fault.remedy.empty());
}

class QuarterSlabFault : public ::testing::TestWithParam<Mistake> {};

TEST_P(QuarterSlabFault, IsFoundAndSaysHowToMendIt) {
  expect_one_fault(small_quarter_slab(), GetParam());
}

/// Drills holes into the block of a case with water in the gap.
void drill(Case& c, std::vector<thermal::DrainHole> holes) {
  c.cooling.bottom_block.wet_coefficient.reset();
  c.cooling.bottom_block.gap_water.emplace();
  c.cooling.water.boiling_follows_flow = true;
  c.cooling.bottom_block.drain_holes = std::move(holes);
}

const Mistake mistakes[] = {
    {"NoOpening", "section.half_thickness", [](Case& c) { c.section.half_thickness = {}; }},
    {"OpeningThatWidens", "section.half_thickness",
     [](Case& c) {
       c.section.half_thickness = {Abscissa::distance, {0.0, 0.12, 0.28}, {0.15, 0.15, 0.16}};
     }},
    {"HollowFace", "section.half_thickness",
     [](Case& c) {
       c.section.half_thickness = {Abscissa::distance, {0.0, 0.12, 0.28}, {0.16, 0.150, 0.149}};
     }},
    {"TableThatEndsBeforeTheNarrowFace", "section.half_thickness",
     [](Case& c) {
       c.section.half_thickness = {Abscissa::distance, {0.0, 0.2}, {0.16, 0.15}};
     }},
    {"BreakPointsCloserThanColumns", "mesh.columns",
     [](Case& c) {
       c.section.half_thickness = {Abscissa::distance,
                                   {0.0, 0.12, 0.121, 0.122, 0.28},
                                   {0.18, 0.1799, 0.17989, 0.17987, 0.14}};
     }},
    {"LayerWiderThanTheSlab", "mesh.wide_side_cell",
     [](Case& c) { c.section.wide_side_cell = 0.2; }},
    {"MoreNodesInARowThanInAMesh", "mesh.columns",
     [](Case& c) { c.section.columns = c.section.layers = 5000; }},  // no plan is built
    {"MonitorWithoutAHeight", "monitor[1].z", [](Case& c) { c.monitors[1].z.reset(); }},
    {"MonitorAboveTheSlab", "monitor[2].z", [](Case& c) { c.monitors[2].z = 0.09; }},
    {"MonitorBehindTheWideFace", "monitor[0].y", [](Case& c) { c.monitors[0].y = 0.145; }},
    {"BlockThatTouchesNowhere", "cooling.bottom_block.profile_x",
     [](Case& c) {
       c.cooling.bottom_block.profile_x = {Abscissa::distance, {0.0, 0.28}, {1e-3, 5e-3}};
     }},
    {"BlockThatTouchesNowhereAlongY", "cooling.bottom_block.profile_y",
     [](Case& c) { c.cooling.bottom_block.profile_y = Curve(2e-3); }},
    {"MonitorInAFlatBlock", "monitor[0].z", [](Case& c) { c.monitors[0].z = -0.01; }},
    {"MonitorBelowTheBowl", "monitor[0].z",
     [](Case& c) {
       c.section.bowl = {.depth = 0.02, .lip = 0.02, .wall = 0.08};
       c.monitors[0] = {.name = "too deep", .x = 0.0, .y = 0.0, .z = -0.021};
     }},
    {"BowlSteeperThanItsMesh", "cooling.bottom_block.bowl.wall",
     [](Case& c) { c.section.bowl = {.depth = 0.04, .lip = 0.02, .wall = 0.03}; }},
    {"BowlWiderThanTheBlock", "cooling.bottom_block.bowl.wall",
     [](Case& c) { c.section.bowl = {.depth = 0.02, .lip = 0.10, .wall = 0.08}; }},
    {"HoleBesideTheBlock", "cooling.bottom_block.drain_hole[1]",
     [](Case& c) {
       drill(c, {{0.1, 0.1, 0.02}, {0.275, 0.1, 0.02}});
     }},
    {"HoleInTheRoundedCorner", "cooling.bottom_block.drain_hole[0]",
     [](Case& c) {
       c.section.corner_radius = 0.06;
       c.monitors.erase(c.monitors.begin());
       drill(c, {{0.265, 0.125, 0.02}});
     }},
    {"HoleCutByAPlaneOfSymmetry", "cooling.bottom_block.drain_hole[0].x",
     [](Case& c) {
       drill(c, {{0.005, 0.1, 0.02}});
     }},
    {"HoleWithoutWaterInTheGap", "cooling.bottom_block.drain_hole",
     [](Case& c) {
       c.cooling.bottom_block.drain_holes = {{0.1, 0.1, 0.02}};
     }},
    {"CornerBeyondTheLastBreakPoint", "section.corner_radius",
     [](Case& c) { c.section.corner_radius = 0.17; }},
    {"CornerThatHoldsNoCells", "section.corner_radius",
     [](Case& c) { c.section.corner_radius = 0.01; }},
    {"MonitorInTheRoundedCorner", "monitor[0].y", [](Case& c) { c.section.corner_radius = 0.06; }},
    {"TooManyNodes", "mesh.columns", [](Case& c) { c.limits.maximum_nodes = 110; }},
    {"TooManyNodesOfTheHeat", "mesh.columns",
     [](Case& c) {
       c.section.heat_cells.per_layer = 5;
       c.limits.maximum_nodes = 300;
     }},
    {"HeatCellsInTetrahedra", "mesh.heat_cells_per_column",
     [](Case& c) {
       c.section.element = mesh::ElementKind::p1;
       c.section.heat_cells.per_column = 2;
     }},
};
INSTANTIATE_TEST_SUITE_P(Mistakes, QuarterSlabFault, ::testing::ValuesIn(mistakes),
                         [](const auto& mistake) { return mistake.param.name; });

TEST(QuarterSlabCheck, WhatIsOfAQuarterSlabOnlyIsRefusedInASection) {
  Case c = small_casting();
  c.section.half_thickness = Curve(0.15);
  c.section.corner_radius = 0.03;
  c.section.heat_cells = {.per_column = 2, .per_layer = 2};
  c.cooling.bottom_block.profile_y = Curve(0.0);
  c.cooling.bottom_block.drain_holes = {{0.1, 0.1, 0.02}};
  c.monitors[0].z = 0.0;
  std::vector<std::string> fields;
  const CheckedCase checked = check(c);
  for (const Fault& fault : checked.faults.list()) fields.push_back(fault.field);
  EXPECT_EQ(fields,
            (std::vector<std::string>{"section.half_thickness", "section.corner_radius",
                                      "mesh.heat_cells_per_column", "mesh.heat_cells_per_layer",
                                      "cooling.bottom_block.profile_y",
                                      "cooling.bottom_block.drain_hole", "monitor[0].z"}));
}

/// A table that reaches beyond the slab may be zero out there alone: the slab is not.
TEST(QuarterSlabCheck, NoRowsAreLaidOutOverAFaultyDepth) {
  for (const double depth : {10.0, -0.01}) {
    Case c = small_quarter_slab();
    c.section.growth_cell.reset();
    c.section.merging = {.below = 0.05, .largest_cell = 0.05};
    c.section.initial_depth = depth;
    const CheckedCase checked = check(c, {"section.initial_depth"});
    for (const Fault& fault : checked.faults.list())
      EXPECT_NE(fault.field, "mesh.merged_cell") << depth;
  }
}

TEST(QuarterSlabCheck, AProfileIsJudgedWhereTheSlabIs) {
  Case c = small_quarter_slab();
  c.cooling.bottom_block.profile_x = {Abscissa::distance, {0.0, 0.5}, {5e-3, 0.0}};
  ASSERT_EQ(check(c).faults.list().size(), 1u);
  c.cooling.bottom_block.profile_x = {Abscissa::distance, {0.0, 0.28}, {5e-3, 0.0}};
  EXPECT_TRUE(check(c).faults.empty());
}

TEST(QuarterSlabCheck, TheEstimateGrowsWithThePlan) {
  const Case coarse = small_quarter_slab();
  Case fine = coarse;
  fine.section.refinement = 3;
  const Estimate one = check(coarse).estimate, other = check(fine).estimate;
  EXPECT_GT(other.solver_seconds, 10.0 * one.solver_seconds);
  EXPECT_GT(other.memory_bytes, 2.0 * one.memory_bytes);
}

/// A casting over the plan of a cross: an arm of 0.28 by 0.06 m, and a stem 0.12 m wide up to 0.15
/// m.
class OwnPlanFault : public QuarterSlabFault {
protected:
  Case casting() {
    const auto cross =
        dccast::testing::draw_plan({0, 0.06, 0.12, 0.2, 0.28}, {0, 0.06, 0.1, 0.15},
                                   [](double x, double y) { return x < 0.12 || y < 0.06; });
    dccast::testing::write_text(dccast::testing::gmsh_text(cross), folder_ / "cross.msh");

    Case c = small_quarter_slab();
    c.section.file = folder_ / "cross.msh";
    c.section.half_thickness = Curve(0.15);
    c.monitors = {{"arm", 0.28, 0.06, 0.0}, {"stem", 0.0, 0.15, 0.0}};
    return c;
  }
  TemporaryFolder folder_;
};

TEST_P(OwnPlanFault, IsFoundAndSaysHowToMendIt) {
  expect_one_fault(casting(), GetParam());
}

const Mistake plan_mistakes[] = {
    {"AnotherWidth", "mesh.file", [](Case& c) { c.section.half_width = 0.29; }},
    {"AnotherOpeningInTheMiddle", "mesh.file",
     [](Case& c) { c.section.half_thickness = Curve(0.153); }},
    {"AnotherOpeningAtABreakPoint", "mesh.file",
     [](Case& c) {
       c.section.half_thickness = {Abscissa::distance, {0.0, 0.2, 0.28}, {0.15, 0.148, 0.14}};
     }},
    {"Tetrahedra", "mesh.element", [](Case& c) { c.section.element = mesh::ElementKind::p1; }},
    {"HeatCells", "mesh.heat_cells_per_column",
     [](Case& c) { c.section.heat_cells.per_column = 2; }},
    {"CornerRadius", "section.corner_radius", [](Case& c) { c.section.corner_radius = 0.03; }},
    {"TooManyNodes", "mesh.file", [](Case& c) { c.limits.maximum_nodes = 100; }},
    {"RefinedBeyondTheLimit", "mesh.file", [](Case& c) { c.section.refinement = 32; }},
    {"NoGrowth", "mesh.file", [](Case& c) { c.section.growth = false; }},
    {"MissingFile", "mesh.file", [](Case& c) { c.section.file = "nowhere.msh"; }},
    {"MonitorBesideTheArm", "monitor[0].y", [](Case& c) { c.monitors[0].y = 0.07; }},
    {"MonitorAboveTheMetal", "monitor[1].z", [](Case& c) { c.monitors[1].z = 0.1; }},
    {"MonitorInTheBlock", "monitor[0].z", [](Case& c) { c.monitors[0].z = -0.01; }},
    {"HoleBesideTheArm", "cooling.bottom_block.drain_hole[0]",
     [](Case& c) { drill(c, {{.x = 0.2, .y = 0.1, .diameter = 0.02}}); }},
    {"MonitorUnderTheFaceBesideABowl", "monitor[1].z",
     [](Case& c) {
       c.section.bowl = {.depth = 0.02, .lip = 0.02, .wall = 0.04};
       c.monitors[1].z = -0.01;
     }},
};
INSTANTIATE_TEST_SUITE_P(Mistakes, OwnPlanFault, ::testing::ValuesIn(plan_mistakes),
                         [](const auto& mistake) { return mistake.param.name; });

/// A drawing in millimetres is refused with its factor.
TEST(OwnPlan, InMillimetresIsRefusedWithTheFactor) {
  const TemporaryFolder folder;
  const auto plan =
      dccast::testing::draw_plan({0, 140, 280}, {0, 75, 150}, [](double, double) { return true; });
  dccast::testing::write_text(dccast::testing::gmsh_text(plan), folder / "plan.msh");
  Case c = small_quarter_slab();
  c.section.file = folder / "plan.msh";
  c.monitors.clear();
  const CheckedCase checked = check(c);
  ASSERT_EQ(checked.faults.list().size(), 1u) << testing::all(checked.faults);
  EXPECT_NE(checked.faults.list()[0].remedy.find("millimetres"), std::string::npos);
}

}  // namespace
}  // namespace dccast::casting
