#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/judging/judged_study.hpp"
#include "tests/support/judged_table.hpp"

namespace dccast::judging {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using support::table_of;

using Values = std::initializer_list<double>;

v1::MouldFace& add_run(v1::StudyResult& result, Values mould_m, Values cold_m, double residual_m) {
  v1::StudyRun& run = *result.add_runs();
  run.set_state(v1::SUCCEEDED);
  run.set_job("job-" + std::to_string(result.runs_size()));
  v1::MouldFace& face = *run.mutable_face();
  face.set_height_m(0.8);
  face.set_change_m(0.1e-3);
  face.set_residual_m(residual_m);
  face.mutable_x_m()->Add(0.0);
  face.mutable_x_m()->Add(0.66);
  face.mutable_half_mould_m()->Add(mould_m.begin(), mould_m.end());
  face.mutable_half_thickness_m()->Add(cold_m.begin(), cold_m.end());
  return face;
}

/// Two runs: a rectangle whose slab is 20 mm hollow, and the mould that was found.
v1::StudyResult design(double residual_m, bool within) {
  v1::StudyResult result;
  v1::Study& study = *result.mutable_study();
  study.set_state(v1::STUDY_SUCCEEDED);
  study.set_runs(2);
  study.mutable_mould()->set_tolerance_m(0.5e-3);
  v1::StudyResult::MouldFound& found = *result.mutable_mould();
  for (const double x : {0.0, 0.2, 0.42, 0.66}) found.add_x_m(x);
  for (const double half : {0.304, 0.304, 0.298, 0.2908}) found.add_half_opening_m(half);
  found.set_residual_m(residual_m);
  found.set_within_tolerance(within);
  found.set_wanted_half_thickness_m(0.285);
  found.set_is_steady(true);

  add_run(result, {0.285, 0.285}, {0.265, 0.279}, 0.020);
  v1::MouldFace& face = add_run(result, {0.304, 0.2908}, {0.285 - residual_m, 0.285}, residual_m);
  *face.mutable_break_point_m() = found.x_m();
  *face.mutable_half_opening_m() = found.half_opening_m();
  return result;
}

v1::Judgement judged_mould(v1::StudyResult result) {
  return judge_study({std::move(result)});
}

TEST(Mould, StatesWhatWasFound) {
  const v1::Judgement judgement = judged_mould(design(0.3e-3, true));
  EXPECT_THAT(
      judgement.sentences(),
      ElementsAre("A mould with half-openings of 304.00 mm from the middle to 200 mm, 298.00 mm at "
                  "420 mm, 290.80 mm at 660 mm gives a cold slab of half-thickness 285.00 mm, flat "
                  "within 0.30 mm (tolerance 0.50 mm), after 2 runs.",
                  "Read 800 mm above the block, around which the half-thickness changes by 0.10 "
                  "mm."));

  const v1::Table trials = table_of(judgement, "trials");
  ASSERT_EQ(trials.rows_size(), 2);
  EXPECT_DOUBLE_EQ(trials.rows(0).cells(4).value(), 0.020) << "what the first run was off";
  EXPECT_EQ(trials.rows(1).cells(2).text(), "0, 200, 420, 660");
  EXPECT_EQ(trials.rows(1).cells(3).text(), "304.00, 304.00, 298.00, 290.80");

  const v1::Table opening = table_of(judgement, "opening");
  ASSERT_EQ(opening.rows_size(), 4);
  EXPECT_NEAR(opening.rows(0).cells(3).value(), 0.0667, 1e-4) << "open over what is wanted";
  const v1::Table slab = table_of(judgement, "cold_slab");
  ASSERT_EQ(slab.rows_size(), 2);
  EXPECT_NEAR(slab.rows(0).cells(3).value(), -0.3e-3, 1e-12);
}

TEST(Mould, StatesWhyItIsNotFlat) {
  v1::StudyResult result = design(0.8e-3, false);
  EXPECT_THAT(judged_mould(result).sentences(0),
              HasSubstr("three straight segments cannot come closer"));
  result.mutable_study()->mutable_mould()->set_maximum_runs(2);
  EXPECT_THAT(judged_mould(result).sentences(0), HasSubstr("these were all the runs permitted"));
  result.mutable_study()->set_state(v1::STUDY_RUNNING);
  EXPECT_THAT(judged_mould(result).sentences(0), HasSubstr("within 0.80 mm of flat so far"));
  EXPECT_THAT(judged_mould(result).sentences(1), Not(HasSubstr("not steady")));
  result.mutable_mould()->set_is_steady(false);
  EXPECT_THAT(judged_mould(result).sentences(1),
              HasSubstr("not steady yet and may contract further"));
}

TEST(Mould, NamesTheReasonOfARunWithoutASlab) {
  v1::StudyResult result = design(0.8e-3, false);
  result.mutable_runs(1)->clear_face();
  result.mutable_runs(1)->set_face_fault("it melted through");
  const v1::Judgement judgement = judged_mould(result);
  EXPECT_EQ(table_of(judgement, "trials").note(), "run 2: it melted through");
  EXPECT_FALSE(table_of(judgement, "trials").rows(1).cells(4).has_value());

  result.clear_runs();
  EXPECT_THAT(judged_mould(result).sentences(), ElementsAre("No run has shown a cold slab yet."));
}

TEST(Mould, ChartsHaveMouldAndSlabOfEveryRunAndWhatIsWanted) {
  const v1::Judgement judgement = judged_mould(design(0.3e-3, true));
  std::vector<v1::Chart> charts;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_chart()) charts.push_back(part.chart());
  ASSERT_EQ(charts.size(), 2u);
  EXPECT_EQ(charts[0].lines_size(), 2);
  EXPECT_EQ(charts[0].lines(1).name(), "run 2");
  EXPECT_DOUBLE_EQ(charts[0].lines(1).y(0), 0.304);
  EXPECT_DOUBLE_EQ(charts[1].lines(0).y(0), 0.265);
  EXPECT_DOUBLE_EQ(charts[1].region().high(), 0.2855);
}

}  // namespace
}  // namespace dccast::judging
