#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/judging/judged_study.hpp"
#include "tests/support/judged_table.hpp"

namespace dccast::judging {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using support::table_of;

v1::StudyResult calibrated() {
  v1::StudyResult result;
  result.mutable_study()->set_id("0f8fad5b-d9cb-469f-a165-70867728950e");
  for (const auto& [key, low, high] : {std::tuple("alloy.specific_heat.scale", "0.95", "1.05"),
                                       std::tuple("cooling.bottom_block.wet_gap", "2 mm", "5 mm"),
                                       std::tuple("cooling.water.wetting.lag", "0.5 s", "5 s")}) {
    auto& axis = *result.mutable_study()->mutable_sweep()->add_axes();
    axis.set_key(key);
    axis.add_values(low);
    axis.add_values(high);
  }
  auto& calibration = *result.mutable_calibration();
  const auto add = [&](double narrowed, const char* low, const char* best, const char* high) {
    auto& key = *calibration.add_keys();
    key.set_narrowed(narrowed);
    key.set_low_text(low);
    key.set_best_text(best);
    key.set_high_text(high);
    for (int i = 0; i < 3; ++i) key.add_correlation(0.0);
  };
  add(0.2, "0.971234", "0.98", "0.991");
  add(0.4, "2.4 mm", "2.71828 mm", "3 mm");
  add(0.95, "0.7 s", "2.5 s", "4.8 s");
  calibration.mutable_keys(1)->set_correlation(0, -0.87);
  calibration.set_fixed(1);
  calibration.set_mesh_error(0.2);
  calibration.add_runs(64);
  auto& curve = *calibration.add_curves();
  curve.mutable_measured()->set_monitor("corner");
  curve.mutable_measured()->set_source("curl.csv");
  curve.set_readings(80);
  for (int i = 0; i < 3; ++i) {
    curve.mutable_measured()->add_time_s(i);
    curve.mutable_measured()->add_curl_m(1e-3 * i);
    curve.add_time_s(i);
    curve.add_best(1e-3 * i);
    for (auto* band : {curve.mutable_before(), curve.mutable_after()}) {
      band->add_low(0.8e-3 * i);
      band->add_median(1e-3 * i);
      band->add_high(1.2e-3 * i);
    }
  }
  curve.set_surface_error(0.2e-3);
  curve.set_check_error(0.3e-3);
  curve.set_checked_error(0.2e-3);
  curve.set_is_confirmed(true);
  for (auto* share : {curve.mutable_noise(), curve.mutable_misfit()}) {
    share->set_low(0.1e-3);
    share->set_median(0.5e-3);
    share->set_high(0.9e-3);
  }
  return result;
}

v1::Judgement judged_calibration(v1::StudyResult result) {
  return judge_study({std::move(result)});
}

TEST(Calibration, StatesWhatIsNarrowedAndWhatCannotBeSeparated) {
  const v1::Judgement judgement = judged_calibration(calibrated());
  EXPECT_THAT(
      judgement.sentences(),
      ElementsAre(
          "The measurement narrows alloy.specific_heat and cooling.bottom_block.wet_gap.",
          "It does not narrow cooling.water.wetting.lag, whose range stays.",
          "It cannot separate alloy.specific_heat and cooling.bottom_block.wet_gap: more of the "
          "one with less of the other fits as well (correlation -0.87).",
          "Of the 3 free keys it fixes 1 combination.",
          "The model needs no misfit to follow the curls: it is less than 0.90 mm (95 %).",
          "Mesh and time steps leave ± 20 % of a curl open; that is in the ranges.",
          "Runs at the calibrated values and along the ridge are 0.30 mm off the response surface "
          "before them, which has 0.20 mm as its error: it holds. They are part of it now."));

  const v1::Table keys = table_of(judgement, "keys");
  ASSERT_EQ(keys.rows_size(), 3);
  EXPECT_EQ(keys.rows(0).cells(1).text(), "± 5 %");
  EXPECT_EQ(keys.rows(0).cells(3).text(), "0.9712..0.991 times");
  EXPECT_EQ(keys.rows(1).cells(2).text(), "2.718 mm");
  EXPECT_EQ(keys.rows(1).cells(3).text(), "2.4..3 mm");
  EXPECT_DOUBLE_EQ(keys.rows(1).cells(4).value(), 0.4);
  EXPECT_EQ(keys.rows(0).cells(5).text(), "alloy.specific_heat.scale");
}

TEST(Calibration, CurvesHaveTheirFiguresWithTheUnitOfWhatWasMeasured) {
  v1::StudyResult result = calibrated();
  auto& second = *result.mutable_calibration()->add_curves();
  second.mutable_measured()->set_monitor("tc 1");
  second.mutable_measured()->add_temperature_c(600.0);
  second.mutable_noise()->set_median(2.0);
  const v1::Judgement judgement = judged_calibration(result);

  const v1::Table curls = table_of(judgement, "curls");
  ASSERT_EQ(curls.rows_size(), 1);
  EXPECT_EQ(curls.rows(0).cells(0).text(), "curl of corner");
  EXPECT_EQ(curls.rows(0).cells(1).text(), "curl.csv");
  EXPECT_EQ(curls.rows(0).cells(2).text(), "3 of 80");
  EXPECT_EQ(curls.columns(5).unit(), "m");
  EXPECT_DOUBLE_EQ(curls.rows(0).cells(5).value(), 0.5e-3);
  EXPECT_NEAR(curls.rows(0).cells(5).lower_error(), 0.4e-3, 1e-12);

  const v1::Table temperatures = table_of(judgement, "temperatures");
  ASSERT_EQ(temperatures.rows_size(), 1);
  EXPECT_EQ(temperatures.columns(5).unit(), "K");
  EXPECT_DOUBLE_EQ(temperatures.rows(0).cells(5).value(), 2.0);
}

TEST(Calibration, StatesThatTheModelIsWrongAndThatTheSurfaceDidNotHold) {
  v1::StudyResult result = calibrated();
  auto& curve = *result.mutable_calibration()->mutable_curves(0);
  curve.mutable_misfit()->set_low(0.6e-3);
  curve.set_check_error(2e-3);
  curve.set_is_confirmed(false);
  EXPECT_THAT(judged_calibration(result).sentences(),
              Contains(HasSubstr("something is wrong or missing")));
  EXPECT_THAT(judged_calibration(result).sentences(), Contains(HasSubstr("it did not hold")));
}

TEST(Calibration, StatesWhereTheFitBecameWorse) {
  v1::StudyResult result = calibrated();
  auto& curve = *result.mutable_calibration()->mutable_curves(0);
  curve.set_off_before(0.2e-3);
  curve.set_off_after(0.5e-3);
  EXPECT_THAT(judged_calibration(result).sentences(),
              Contains(HasSubstr("The fit to the curl of corner became worse: 0.20 off before, "
                                 "0.50 mm after.")));
  curve.set_off_after(0.1e-3);
  EXPECT_THAT(judged_calibration(result).sentences(), Not(Contains(HasSubstr("became worse"))));
}

TEST(Calibration, NamesTheReasonForNoAnswer) {
  v1::StudyResult result = calibrated();
  result.clear_calibration();
  result.set_calibration_fault("needs 43 valid runs");
  EXPECT_THAT(judged_calibration(result).sentences(),
              ElementsAre("The study has no answer: needs 43 valid runs"));
}

TEST(Calibration, DrawsReadingsAsDotsOverTheBandsOfDataAndMesh) {
  const v1::Judgement judgement = judged_calibration(calibrated());
  const auto part = std::ranges::find_if(judgement.parts(), &v1::JudgementPart::has_chart);
  ASSERT_NE(part, judgement.parts().end());
  const v1::Chart& chart = part->chart();
  ASSERT_EQ(chart.lines_size(), 4);
  EXPECT_TRUE(chart.lines(0).is_dotted());
  EXPECT_EQ(chart.lines(1).name(), "data before, 5 to 95 %");
  EXPECT_EQ(chart.lines(2).name(), "data after, 5 to 95 %");
  EXPECT_DOUBLE_EQ(chart.lines(2).high(2), 2.4e-3);
  EXPECT_EQ(chart.lines(3).name(), "mesh and time steps");
  EXPECT_DOUBLE_EQ(chart.lines(3).high(2), 2.4e-3);
}

}  // namespace
}  // namespace dccast::judging
