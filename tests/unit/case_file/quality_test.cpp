#include "proto/case_file/quality.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::case_file {
namespace {

v1::Case casting(v1::Quality quality) {
  v1::Case c;
  c.set_quality(quality);
  c.mutable_section()->set_half_width_m(0.28);
  c.mutable_section()->set_initial_depth_m(0.10);
  c.mutable_schedule()->set_hold_s(60.0);
  c.mutable_time()->set_end_s(145.0);
  return c;
}

v1::Case complete(v1::Case c) {
  apply_defaults(c);
  return c;
}

/// The step that holds at a time, interpolated as the schedule does.
double step_at(const v1::Curve& steps, double time) {
  int i = 0;
  while (i + 1 < steps.at_size() && steps.at(i + 1) <= time) ++i;
  if (i + 1 == steps.at_size() || time <= steps.at(0)) return steps.value(i);
  const double share = (time - steps.at(i)) / (steps.at(i + 1) - steps.at(i));
  return steps.value(i) + share * (steps.value(i + 1) - steps.value(i));
}

TEST(Quality, BetterQualitiesHaveSmallerCellsAndSteps) {
  const auto draft = complete(casting(v1::DRAFT)), engineering = complete(casting(v1::ENGINEERING)),
             fine = complete(casting(v1::FINE));
  for (const auto& [better, worse] :
       {std::pair(engineering, draft), std::pair(fine, engineering)}) {
    EXPECT_GT(better.mesh().columns(), worse.mesh().columns());
    EXPECT_GT(better.mesh().rows(), worse.mesh().rows());
    EXPECT_LT(better.mesh().side_cell_m(), worse.mesh().side_cell_m());
    EXPECT_LT(better.mesh().bottom_cell_m(), worse.mesh().bottom_cell_m());
    EXPECT_LT(better.mesh().growth_cell_m(), worse.mesh().growth_cell_m());
    EXPECT_LT(step_at(better.time().step_s(), 0.0), step_at(worse.time().step_s(), 0.0));
  }
}

/// A case as large as start-3d.
v1::Case quarter_slab(v1::Quality quality) {
  v1::Case c = casting(quality);
  c.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  c.mutable_section()->set_half_width_m(0.66);
  c.mutable_section()->mutable_half_thickness_m()->add_at(0.0);
  c.mutable_section()->mutable_half_thickness_m()->add_value(0.285);
  c.mutable_section()->set_initial_depth_m(0.066);
  return c;
}

TEST(Quality, OfAQuarterSlabPicksBothDirectionsOfThePlan) {
  const auto draft = complete(quarter_slab(v1::DRAFT)).mesh(),
             engineering = complete(quarter_slab(v1::ENGINEERING)).mesh(),
             fine = complete(quarter_slab(v1::FINE)).mesh();
  EXPECT_EQ(engineering.columns(), 8);
  EXPECT_EQ(engineering.layers(), 9);
  EXPECT_EQ(draft.columns(), 7);
  EXPECT_EQ(draft.layers(), 8);
  EXPECT_EQ(draft.rows(), 12);
  for (const auto& mesh : {draft, engineering, fine}) {
    EXPECT_NEAR(mesh.side_cell_m() * mesh.columns(), 0.66, 1e-12) << "even";
    EXPECT_NEAR(mesh.wide_side_cell_m() * mesh.layers(), 0.285, 1e-12) << "even";
    EXPECT_GE(mesh.heat_cells_per_column(), 3);
    EXPECT_GE(mesh.heat_cells_per_layer(), 2);
  }

  for (const auto& [better, worse] :
       {std::pair(engineering, draft), std::pair(fine, engineering)}) {
    EXPECT_GT(better.columns(), worse.columns());
    EXPECT_GT(better.layers(), worse.layers());
    EXPECT_GT(better.rows(), worse.rows());
    EXPECT_LT(better.side_cell_m(), worse.side_cell_m());
    EXPECT_LT(better.wide_side_cell_m(), worse.wide_side_cell_m());
    EXPECT_LE(better.growth_cell_m(), worse.growth_cell_m());
  }
}

TEST(Quality, MergesTheRowsOfAQuarterSlabThatItHasChosen) {
  const auto mesh_of = [](auto&& change) {
    v1::Case c = quarter_slab(v1::DRAFT);
    change(*c.mutable_mesh());
    return complete(c).mesh();
  };
  const auto draft = mesh_of([](v1::Mesh&) {});
  EXPECT_DOUBLE_EQ(draft.merge_below_m(), 0.1);
  EXPECT_DOUBLE_EQ(draft.merged_cell_m(), 0.02);
  EXPECT_EQ(mesh_of([](v1::Mesh& m) { m.set_growth_cell_m(5e-3); }).merge_below_m(), 0.0);
  EXPECT_EQ(mesh_of([](v1::Mesh& m) { m.set_element(v1::P1); }).merge_below_m(), 0.0);
  EXPECT_EQ(complete(casting(v1::DRAFT)).mesh().merge_below_m(), 0.0) << "of a section";
  EXPECT_DOUBLE_EQ(mesh_of([](v1::Mesh& m) { m.set_file("plan.msh"); }).merge_below_m(), 0.1);
  EXPECT_EQ(mesh_of([](v1::Mesh& m) {
              m.set_file("slab.msh");
              m.set_growth(false);
            }).merge_below_m(),
            0.0)
      << "of a mesh without rows";

  const auto own = mesh_of([](v1::Mesh& m) {
    m.set_growth_cell_m(12e-3);
    m.set_merge_below_m(0.3);
  });
  EXPECT_DOUBLE_EQ(own.merge_below_m(), 0.3);
  EXPECT_DOUBLE_EQ(own.merged_cell_m(), 0.024) << "two growth cells at least";
}

TEST(Quality, LeavesTheLayersOfAQuarterSlabToTheCase) {
  v1::Case c = quarter_slab(v1::DRAFT);
  c.mutable_mesh()->set_layers(40);
  EXPECT_LE(complete(c).mesh().wide_side_cell_m(), 0.285 / 40) << "no wider than its layer";
  c.mutable_mesh()->set_wide_side_cell_m(3e-3);
  EXPECT_DOUBLE_EQ(complete(c).mesh().wide_side_cell_m(), 3e-3);
}

TEST(Quality, APlanOfTheCaseIsTheHeatsToo) {
  v1::Case own = quarter_slab(v1::DRAFT), more = own, tetrahedra = own,
           section = casting(v1::DRAFT);
  own.mutable_mesh()->set_columns(12);
  more.mutable_mesh()->set_columns(12);
  more.mutable_mesh()->set_heat_cells_per_layer(4);
  tetrahedra.mutable_mesh()->set_element(v1::P1);
  EXPECT_EQ(complete(own).mesh().heat_cells_per_column(), 1);
  EXPECT_EQ(complete(own).mesh().heat_cells_per_layer(), 1);
  EXPECT_EQ(complete(more).mesh().heat_cells_per_column(), 1);
  EXPECT_EQ(complete(more).mesh().heat_cells_per_layer(), 4);
  EXPECT_EQ(complete(tetrahedra).mesh().heat_cells_per_column(), 1);
  EXPECT_FALSE(complete(section).mesh().has_heat_cells_per_column());

  // What was completed stays as it is.
  const v1::Case draft = complete(quarter_slab(v1::DRAFT));
  EXPECT_EQ(complete(draft).SerializeAsString(), draft.SerializeAsString());
}

TEST(Quality, IsEngineeringWhereTheCaseDoesNotSay) {
  const v1::Case silent = complete(casting(v1::QUALITY_UNSPECIFIED));
  EXPECT_EQ(silent.SerializeAsString(), complete(casting(v1::ENGINEERING)).SerializeAsString());
  EXPECT_EQ(silent.quality(), v1::ENGINEERING);
}

TEST(Quality, ColumnsAreUniformAndMoreOfThemInAWideSection) {
  v1::Case wide = casting(v1::ENGINEERING);
  wide.mutable_section()->set_half_width_m(0.66);
  const v1::Case narrow = complete(casting(v1::ENGINEERING));
  wide = complete(wide);
  EXPECT_NEAR(wide.mesh().side_cell_m() * wide.mesh().columns(), 0.66, 1e-12);
  EXPECT_NEAR(wide.mesh().side_cell_m(), narrow.mesh().side_cell_m(), 0.5e-3);
}

TEST(Quality, ExplicitKeysWin) {
  v1::Case c = casting(v1::FINE);
  c.mutable_mesh()->set_columns(7);
  c.mutable_mesh()->set_bottom_cell_m(4e-3);
  c.mutable_time()->mutable_step_s()->add_at(0.0);
  c.mutable_time()->mutable_step_s()->add_value(2.0);
  c = complete(c);
  EXPECT_EQ(c.mesh().columns(), 7);
  EXPECT_DOUBLE_EQ(c.mesh().side_cell_m(), 0.04) << "uniform with the columns that are given";
  EXPECT_DOUBLE_EQ(c.mesh().bottom_cell_m(), 4e-3);
  EXPECT_EQ(c.time().step_s().value_size(), 1);
}

TEST(Quality, RowsOfTheCaseGrowInTheirOwnHeight) {
  v1::Case c = casting(v1::DRAFT);
  c.mutable_mesh()->set_rows(2);
  c = complete(c);
  EXPECT_FALSE(c.mesh().has_growth_cell_m());
  EXPECT_LE(c.mesh().bottom_cell_m(), 0.05);
}

TEST(Quality, StepsAreShortAfterEverySuddenEvent) {
  v1::Case c = casting(v1::ENGINEERING);
  c.mutable_mechanics()->set_start_s(20.0);
  c.mutable_cooling()->mutable_water()->set_start_s(40.0);
  const v1::Curve steps = complete(c).time().step_s();
  const double shortest = step_at(steps, 0.0);
  for (const double event : {0.0, 20.0, 40.0}) {
    EXPECT_DOUBLE_EQ(step_at(steps, event), shortest) << event;
    EXPECT_GT(step_at(steps, event + 15.0), shortest) << event;
  }
  EXPECT_LT(step_at(steps, -60.0), step_at(steps, -20.0));
  for (int i = 1; i < steps.at_size(); ++i) EXPECT_LT(steps.at(i - 1), steps.at(i));
}

/// Steps end at every point of their table: points close together would make steps of next to
/// nothing, in which rounding outweighs the heat that moves.
TEST(Quality, PointsOfTheStepTableAreAStepApart) {
  for (const auto quality : {v1::DRAFT, v1::ENGINEERING, v1::FINE}) {
    const v1::Curve steps = complete(casting(quality)).time().step_s();
    for (int i = 1; i < steps.at_size(); ++i)
      EXPECT_GE(steps.at(i) - steps.at(i - 1), steps.value(i - 1) * (1.0 - 1e-9)) << steps.at(i);
  }
}

TEST(Quality, EventsOutsideTheRunLeaveNoTrace) {
  v1::Case c = casting(v1::ENGINEERING);
  c.mutable_schedule()->set_hold_s(0.0);
  c.mutable_time()->set_end_s(5.0);
  c.mutable_cooling()->mutable_water()->set_start_s(1000.0);
  const v1::Curve steps = complete(c).time().step_s();
  EXPECT_LT(steps.at(steps.at_size() - 1), 5.0);
  EXPECT_TRUE(check_ranges(complete(c)).empty());
}

/// For any sizes of a case, right or wrong, the mesh is finite and the case has steps.
TEST(Quality, StaysInRangeForAnySection) {
  for (const auto kind :
       {v1::Section::PLANE_STRAIN, v1::Section::AXISYMMETRIC, v1::Section::QUARTER_SLAB})
    for (const auto quality : {v1::DRAFT, v1::ENGINEERING, v1::FINE})
      for (const double width : {0.005, 0.1, 3.0})
        for (const double depth : {0.005, 0.1, 5.0}) {
          v1::Case c = casting(quality);
          c.mutable_section()->set_kind(kind);
          c.mutable_section()->set_half_width_m(width);
          c.mutable_section()->set_initial_depth_m(depth);
          c.mutable_section()->mutable_half_thickness_m()->add_at(0.0);
          c.mutable_section()->mutable_half_thickness_m()->add_value(width);
          const auto faults = check_ranges(complete(c));
          EXPECT_TRUE(faults.empty()) << width << " " << depth << " " << faults.front().field();
        }
  v1::Case at_fault;
  at_fault.mutable_time()->set_end_s(-5.0);
  EXPECT_EQ(complete(at_fault).time().step_s().value_size(), 1);
}

/// What is no number is told as such, and makes no number of cells that no one gave.
TEST(Quality, CountsTheFewestCellsOfWhatIsNoNumber) {
  v1::Case c = casting(v1::DRAFT);
  c.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  c.mutable_section()->mutable_half_thickness_m()->add_at(0.0);
  c.mutable_section()->mutable_half_thickness_m()->add_value(NAN);
  c.mutable_mesh()->set_bottom_cell_m(-1e-3);
  const v1::Mesh mesh = complete(c).mesh();
  EXPECT_EQ(mesh.layers(), 3);
  EXPECT_EQ(mesh.rows(), 4);
}

TEST(DiscretisationError, IsKnownOfTheMeshesAndStepsThatAQualityPicks) {
  for (const auto make : {&casting, &quarter_slab}) {
    const auto error = [make](v1::Quality quality) {
      return relative_discretisation_error(complete(make(quality)));
    };
    ASSERT_TRUE(error(v1::DRAFT) && error(v1::ENGINEERING) && error(v1::FINE));
    EXPECT_GT(error(v1::DRAFT)->upper(), error(v1::ENGINEERING)->upper());
    EXPECT_GE(error(v1::ENGINEERING)->upper(), error(v1::FINE)->upper());
  }
}

/// A coarse mesh of a quarter slab bends too little rather than too much.
TEST(DiscretisationError, OfADraftOfAQuarterSlabReachesFartherUp) {
  const auto draft = relative_discretisation_error(complete(quarter_slab(v1::DRAFT)));
  EXPECT_GT(draft->lower(), 0.0);
  EXPECT_GT(draft->upper(), draft->lower());
}

/// The bands hold the truths of the shipped starts (docs/error-bars.md), here those that are
/// farthest off: least shell over the block above a gap, and above the water [m].
TEST(FigureBands, HoldTheTruthsOfTheStarts) {
  struct Row {
    v1::Quality quality;
    const char* figure;
    double computed, truth;
  };
  for (const Row& row : {Row{v1::DRAFT, "shell over the block", 17.744e-3, 17.271e-3},
                         Row{v1::DRAFT, "shell over the block", 8.0407e-3, 5.9091e-3},
                         Row{v1::ENGINEERING, "shell over the block", 16.362e-3, 17.271e-3},
                         Row{v1::ENGINEERING, "shell over the block", 6.1e-3, 5.9091e-3},
                         Row{v1::ENGINEERING, "shell over the block", 11.338e-3, 14.901e-3},
                         Row{v1::ENGINEERING, "shell over the block", 6.8152e-3, 6.3966e-3},
                         Row{v1::ENGINEERING, "shell above the water", 5.602e-3, 6.233e-3},
                         Row{v1::DRAFT, "shell above the water", 5.2337e-3, 2.8146e-3},
                         Row{v1::ENGINEERING, "shell above the water", 4.5704e-3, 2.8146e-3}}) {
    const auto bands = figure_bands(complete(quarter_slab(row.quality)));
    const auto band = std::ranges::find(bands, std::string(row.figure), &FigureBand::figure);
    ASSERT_NE(band, bands.end()) << row.figure;
    ASSERT_TRUE(band->is_relative);
    EXPECT_GE(row.truth, row.computed * (1.0 - band->below)) << row.figure;
    EXPECT_LE(row.truth, row.computed * (1.0 + band->above)) << row.figure;
  }
}

TEST(FigureBands, AreUnknownWhereTheBandOfTheCurlIs) {
  v1::Case layers = quarter_slab(v1::DRAFT);
  layers.mutable_mesh()->set_layers(4);
  EXPECT_TRUE(figure_bands(complete(layers)).empty());
}

/// The curl that findings judge has its band only at a monitor where it was measured.
TEST(FigureBands, HaveTheCurlOfTheChosenMonitor) {
  v1::Case c = quarter_slab(v1::ENGINEERING);
  const auto has_curl = [&] {
    return std::ranges::count(figure_bands(complete(c)), std::string("curl"), &FigureBand::figure);
  };
  c.mutable_output()->clear_curl();
  EXPECT_EQ(has_curl(), 0);
  v1::Monitor& monitor = *c.add_monitor();
  monitor.set_name("edge");
  monitor.set_x_m(c.section().half_width_m());
  monitor.set_y_m(0.0);
  monitor.set_z_m(0.0);
  c.mutable_output()->set_curl("edge");
  EXPECT_EQ(has_curl(), 1);
}

/// They were measured at the corner and at the middle of the narrow face.
TEST(DiscretisationError, OfAQuarterSlabIsKnownAlongTheNarrowEdgeAndForMeansOfIt) {
  v1::Case c = quarter_slab(v1::DRAFT);
  const double half_width_m = c.section().half_width_m();
  const auto add = [&](const char* name, double x_m, double z_m) {
    v1::Monitor& monitor = *c.add_monitor();
    monitor.set_name(name);
    monitor.set_x_m(x_m);
    monitor.set_y_m(0.0);
    monitor.set_z_m(z_m);
  };
  add("narrow face", half_width_m, 0.0);
  add("above it", half_width_m, 0.1);
  add("wide face", 0.0, 0.0);

  const auto add_mean = [&](const char* name, const char* beside) {
    v1::Monitor& mean = *c.add_monitor();
    mean.set_name(name);
    for (const char* member : {"narrow face", beside}) mean.add_of()->set_monitor(member);
  };
  add_mean("plant", "narrow face");
  add_mean("all around", "wide face");

  const v1::Case all = complete(c);
  for (const char* known : {"narrow face", "plant"})
    EXPECT_TRUE(monitor_error(all, known)) << known;
  for (const char* unknown : {"above it", "wide face", "all around", "nowhere"})
    EXPECT_FALSE(monitor_error(all, unknown)) << unknown;
}

TEST(DiscretisationError, OfAQuarterSlabIsUnknownBeyondItsStartAndOnAnotherMesh) {
  v1::Case later = quarter_slab(v1::DRAFT), layers = later, merged = later, long_slab = later,
           heat = later;
  later.mutable_time()->set_end_s(1500.0);
  layers.mutable_mesh()->set_layers(4);
  merged.mutable_mesh()->set_merge_below_m(0.2);
  long_slab.mutable_section()->set_half_width_m(1.2);
  heat.mutable_mesh()->set_heat_cells_per_column(2);
  for (const auto& c : {later, layers, merged, long_slab, heat})
    EXPECT_FALSE(relative_discretisation_error(complete(c)));
}

/// The bands were measured at the end of castings, on hot slabs.
TEST(DiscretisationError, IsUnknownOfASlabThatCoolsDown) {
  for (const auto make : {&casting, &quarter_slab}) {
    v1::Case cold = make(v1::ENGINEERING);
    cold.mutable_time()->set_cool_down_s(3600.0);
    EXPECT_FALSE(relative_discretisation_error(complete(cold)));
  }
}

/// The bands were measured on flat blocks.
TEST(DiscretisationError, IsUnknownOfABlockWithABowlOrHoles) {
  for (const auto make : {&casting, &quarter_slab}) {
    v1::Case bowl = make(v1::ENGINEERING), hole = bowl;
    ASSERT_TRUE(relative_discretisation_error(complete(bowl)));
    bowl.mutable_cooling()->mutable_bottom_block()->mutable_bowl()->set_depth_m(0.02);
    hole.mutable_cooling()->mutable_bottom_block()->add_drain_hole()->set_diameter_m(0.03);
    EXPECT_FALSE(relative_discretisation_error(complete(bowl)));
    EXPECT_FALSE(relative_discretisation_error(complete(hole)));
  }
}

TEST(DiscretisationError, IsUnknownWhereItWasNotMeasured) {
  v1::Case other_mesh = casting(v1::ENGINEERING), other_steps = other_mesh, billet = other_mesh,
           triangles = other_mesh, wide = other_mesh, file = other_mesh;
  other_mesh.mutable_mesh()->set_rows(7);
  other_steps.mutable_time()->mutable_step_s()->add_at(0.0);
  other_steps.mutable_time()->mutable_step_s()->add_value(2.0);
  billet.mutable_section()->set_kind(v1::Section::AXISYMMETRIC);
  triangles.mutable_mesh()->set_element(v1::P1);
  wide.mutable_section()->set_half_width_m(0.66);
  file.mutable_mesh()->set_file("slab.msh");
  for (const auto& c : {other_mesh, other_steps, billet, triangles, wide, file})
    EXPECT_FALSE(relative_discretisation_error(complete(c)));
}

}  // namespace
}  // namespace dccast::case_file
