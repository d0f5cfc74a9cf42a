#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "server/judging/run_judgement.hpp"
#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::judging {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> part_keys(const v1::Judgement& judgement) {
  std::vector<std::string> keys;
  for (const v1::JudgementPart& part : judgement.parts())
    keys.push_back(part.has_chart() ? part.chart().key() : part.table().key());
  return keys;
}

v1::Table table(const v1::Judgement& judgement, const std::string& key) {
  const auto found = std::ranges::find(judgement.parts(), key,
                                       [](const auto& part) { return part.table().key(); });
  EXPECT_NE(found, judgement.parts().end()) << key;
  return found == judgement.parts().end() ? v1::Table() : found->table();
}

/// The bottom of a section that has lifted off at its second node.
v1::Frame section() {
  v1::Frame frame;
  frame.set_dimension(2);
  for (const double x : {0.0, 0.0, 0.1, 0.0}) frame.add_node_m(x);
  for (const int node : {0, 1}) frame.add_bottom_node(node);
  for (const double gap : {0.0, 4e-3}) frame.add_bottom_gap_m(gap);
  for (const double pressure : {2e3, 0.0}) frame.add_bottom_pressure_pa(pressure);
  return frame;
}

TEST(JudgeFrame, ASectionHasGapAndPressureAlongItsBottom) {
  v1::Judgement judgement;
  add_frame({}, section(), false, judgement);
  ASSERT_THAT(part_keys(judgement), ElementsAre("bottom_gap", "bottom_pressure"));
  EXPECT_THAT(judgement.parts(0).chart().lines(0).x(), ElementsAre(0.0, 0.1));
  EXPECT_THAT(judgement.parts(0).chart().lines(0).y(), ElementsAre(0.0, 4e-3));
  EXPECT_THAT(judgement.parts(1).chart().lines(0).y(), ElementsAre(2e3, 0.0));

  v1::Frame without_mechanics = section();
  without_mechanics.clear_bottom_pressure_pa();
  v1::Judgement gap_alone;
  add_frame({}, without_mechanics, false, gap_alone);
  EXPECT_THAT(part_keys(gap_alone), ElementsAre("bottom_gap"));
}

TEST(JudgeFrame, AFrameBeyondValiditySaysSo) {
  v1::Judgement judgement;
  add_frame({}, section(), true, judgement);
  EXPECT_THAT(judgement.parts(0).chart().note(), testing::StartsWith("Beyond validity. "));
}

TEST(JudgeFrame, AQuarterSlabHasItsLargestGapAndThePullInOfItsFace) {
  v1::Frame frame = frames::testing::cooled(frames::testing::uniform);
  for (const int node : {0, 3, 6}) frame.add_bottom_node(node);
  for (const double gap : {0.0, 1e-3, 5e-3}) frame.add_bottom_gap_m(gap);
  for (const double pressure : {1e4, 0.0, 0.0}) frame.add_bottom_pressure_pa(pressure);
  v1::Judgement judgement;
  add_frame(frames::testing::quarter_slab(), frame, false, judgement);
  ASSERT_THAT(part_keys(judgement), ElementsAre("bottom", "pull_in", "pull_in"));

  const v1::Table bottom = table(judgement, "bottom");
  std::vector<double> figures;
  for (const v1::Cell& cell : bottom.rows(0).cells()) figures.push_back(cell.value());
  EXPECT_THAT(figures, ElementsAre(5e-3, 0.66, 0.290, 1.0, 3.0));

  // Head, middle and butt, each in the middle, half way and at the end. The slab cools freely.
  const v1::Table pull_in = table(judgement, "pull_in");
  ASSERT_THAT(pull_in.rows(), SizeIs(9));
  EXPECT_EQ(pull_in.rows(0).cells(0).text(), "head");
  EXPECT_NEAR(pull_in.rows(0).cells(5).value(), 0.300 * (1.0 - frames::testing::stretch(320.0)),
              1e-12);
  EXPECT_NEAR(pull_in.rows(8).cells(6).value(), 1.0 - frames::testing::stretch(320.0), 1e-12);
}

TEST(JudgeFrame, AMeshWithoutLinesAcrossTheSlabHasNoPullIn) {
  v1::Frame frame;
  frame.set_dimension(3);
  v1::Judgement judgement;
  add_frame({}, frame, false, judgement);
  EXPECT_THAT(part_keys(judgement), IsEmpty());
}

TEST(RunFacts, TheRecipeIsAsAPlantReadsIt) {
  v1::Case input;
  input.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  input.mutable_section()->set_half_width_m(0.66);
  input.mutable_section()->mutable_half_thickness_m()->add_value(0.285);
  input.mutable_schedule()->set_hold_s(60.0);
  input.mutable_schedule()->mutable_casting_speed_m_per_s()->add_value(1e-3);
  input.mutable_schedule()->mutable_casting_speed_factor()->add_value(0.5);
  input.mutable_schedule()->mutable_water_flow_m2_per_s()->add_value(3e-3);
  input.mutable_cooling()->mutable_narrow_water()->set_enabled(false);
  v1::Judgement judgement;
  add_recipe(input, "recipe", judgement);

  const v1::Table recipe = table(judgement, "recipe");
  std::vector<std::string> lines;
  for (const v1::Table::Row& row : recipe.rows())
    lines.push_back(row.cells(0).text() + ": " + row.cells(1).text() + "; " + row.cells(2).text());
  EXPECT_THAT(lines, testing::Contains(HasSubstr("Slab: 1320 × 570 mm")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("Hold before the block moves: 60 s")));
  EXPECT_THAT(lines, testing::Contains("Casting speed: 60 mm/min; times 0.5 "));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("Water, narrow face: 180 l/min/m; turned off")));
}

TEST(RunFacts, TheChecksAreTheWorstOfAllStepsAndSayWhatTheRunTook) {
  JudgedRun run;
  for (const double residual : {1e-9, -4e-8, 2e-9}) {
    v1::StepReport& step = run.steps.emplace_back();
    step.set_equilibrium_residual(residual);
    step.set_iterations(3);
  }
  v1::Judgement judgement;
  add_checks(run, true, judgement);

  const v1::Table checks = table(judgement, "checks");
  EXPECT_EQ(checks.rows(0).cells(1).text(), "4.00e-08");
  EXPECT_THAT(checks.rows(4).cells(2).text(), HasSubstr("last step, beyond validity"));
  EXPECT_EQ(checks.rows(7).cells(1).text(), "9");
  EXPECT_EQ(checks.rows(7).cells(2).text(), "3.00 a step");
}

}  // namespace
}  // namespace dccast::judging
