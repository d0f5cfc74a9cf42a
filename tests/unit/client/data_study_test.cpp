#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "client/html/pages.hpp"
#include "client/model/study.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/study_text.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

void add_axis(v1::StudyResult& result, const std::string& key, const std::string& low,
              const std::string& high) {
  auto& axis = *result.mutable_study()->mutable_sweep()->add_axes();
  axis.set_key(key);
  axis.add_values(low);
  axis.add_values(high);
}

/// A run that moves one axis (-1: none) to an end, with its curl [mm].
v1::StudyRun& add_run(v1::StudyResult& result, int axis, int end, double curl_mm) {
  v1::StudyRun& run = *result.add_runs();
  run.set_state(v1::SUCCEEDED);
  const auto& axes = result.study().sweep().axes();
  for (int i = 0; i < axes.size(); ++i) run.add_values(i == axis ? axes[i].values(end) : "");
  run.add_end_curl_m(1e-3 * curl_mm);
  run.add_end_curl_m(1e-3);
  return run;
}

v1::StudyResult sensitivity() {
  v1::StudyResult result;
  result.add_monitors("corner");
  result.add_monitors("centre");
  add_axis(result, "alloy.specific_heat.scale", "0.97", "1.03");
  add_axis(result, "schedule.casting_speed.scale", "0.9", "1.1");
  add_axis(result, "cooling.water.wetting.lag", "0.5 s", "5 s");
  add_axis(result, "cooling.bottom_block.wet_coefficient", "1000 W/(m2 K)", "3000 W/(m2 K)");
  add_run(result, -1, 0, 40.0);
  add_run(result, 0, 0, 41.0);
  add_run(result, 0, 1, 39.5);
  add_run(result, 1, 0, 35.0);
  add_run(result, 1, 1, 46.0);
  add_run(result, 2, 0, 40.001);
  add_run(result, 2, 1, 39.999);
  v1::StudyRun& lost = add_run(result, 3, 0, 0.0);
  lost.set_state(v1::FAILED);
  lost.mutable_failure()->set_kind(v1::Failure::SHELL_MELTED_THROUGH);
  lost.mutable_failure()->set_message("melts through at 43 s");
  lost.set_end_curl_m(0, std::numeric_limits<double>::quiet_NaN());
  add_run(result, 3, 1, 38.0);
  return result;
}

TEST(Sweep, TableAndCsvHaveTheErrorOfMeshAndStepsWhereItIsKnown) {
  v1::StudyResult result;
  result.add_monitors("corner");
  add_axis(result, "mesh.rows", "10", "20");
  add_run(result, 0, 0, -40.0).set_relative_curl_error(0.05);
  add_run(result, 0, 1, 41.0);
  for (v1::StudyRun& run : *result.mutable_runs()) {
    run.mutable_end_curl_m()->Truncate(1);
    run.add_numbers(10.0);
  }
  const std::string table = render::sweep_table(result), csv = render::sweep_csv(result);
  EXPECT_THAT(table, testing::ContainsRegex("corner mm +\u00b1 mm"));
  EXPECT_THAT(table, testing::ContainsRegex("-40.0 +2.0 +succeeded"));
  EXPECT_THAT(table, testing::ContainsRegex("41.00 +- +succeeded"));
  EXPECT_THAT(csv, HasSubstr("corner_end_curl_m,corner_uncertainty_m,"));
  EXPECT_THAT(csv, HasSubstr(",-0.04,0.002,"));
  EXPECT_THAT(csv, HasSubstr(",0.041,,"));
  result.mutable_runs(0)->clear_relative_curl_error();
  EXPECT_THAT(render::sweep_table(result), Not(HasSubstr("\u00b1")));
}

std::size_t widest_line(const std::string& text) {
  std::istringstream lines(text);
  std::size_t widest = 0;
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, line.size());
  return widest;
}

TEST(Effects, AreDifferencesToTheCaseItselfLargestFirst) {
  const Effects effects = effects_of(sensitivity(), 0, 0.05);
  EXPECT_DOUBLE_EQ(*effects.base_m, 40e-3);
  ASSERT_EQ(effects.effects.size(), 4u);
  EXPECT_EQ(effects.effects[0].axis, 1);
  EXPECT_NEAR(*effects.effects[0].high_m, 6e-3, 1e-12);
  EXPECT_NEAR(*effects.effects[0].low_m, -5e-3, 1e-12);
  EXPECT_EQ(effects.effects[1].axis, 3);
  EXPECT_FALSE(effects.effects[1].low_m);
  EXPECT_EQ(effects.effects[1].low_failure, "melts through at 43 s");
  EXPECT_DOUBLE_EQ(*effects.error_m, 2e-3);
}

TEST(Effects, OfAStudyWithoutTheCaseItselfAreUnknown) {
  v1::StudyResult result = sensitivity();
  result.mutable_runs()->erase(result.runs().begin());  // its job was deleted
  EXPECT_FALSE(effects_of(result, 0, 0.05).base_m);
  EXPECT_THAT(render::sensitivity_text(result, 0, 0.05), HasSubstr("nothing to compare with"));
}

TEST(Effects, AnErrorThatWasNotMeasuredIsNotStated) {
  EXPECT_FALSE(effects_of(sensitivity(), 0, std::nullopt).error_m);
  const std::string text = render::sensitivity_text(sensitivity(), 0, std::nullopt);
  EXPECT_THAT(text, HasSubstr("error of a difference has not been measured for such a case"));
  EXPECT_THAT(text, Not(HasSubstr("is known to")));
  EXPECT_THAT(render::sensitivity_page(sensitivity(), 0, std::nullopt),
              HasSubstr("error of a difference has not been measured"));
}

TEST(Effects, AMonitorIsNamedOrHasTheLargestCurl) {
  EXPECT_EQ(monitor_of(sensitivity(), "centre"), 1);
  EXPECT_EQ(monitor_of(sensitivity(), "edge"), -1);
  EXPECT_EQ(monitor_of(sensitivity(), ""), 0);
}

TEST(Effects, RangesReadAsTheyAreWritten) {
  v1::StudyResult result = sensitivity();
  add_axis(result, "schedule.casting_temperature.offset", "-3 K", "3 K");
  add_axis(result, "cooling.bottom_block.gap_coefficient.scale", "0.67", "1");
  const auto& axes = result.study().sweep().axes();
  EXPECT_EQ(range_of(axes[0]), "± 3 %");
  EXPECT_EQ(range_of(axes[2]), "0.5..5 s");
  EXPECT_EQ(range_of(axes[3]), "1000..3000 W/(m2 K)");
  EXPECT_EQ(range_of(axes[4]), "± 3 K");
  EXPECT_EQ(range_of(axes[5]), "0.67..1 times");
}

TEST(SensitivityText, ShowsLeversDataFailuresAndWhatDoesNotMatter) {
  const std::string text = render::sensitivity_text(sensitivity(), 0, 0.05);
  EXPECT_THAT(text, HasSubstr("9 runs: 8 valid, 1 failed or cancelled"));
  EXPECT_THAT(text, HasSubstr("corner at the end: 40.0 mm"));
  EXPECT_THAT(text, HasSubstr("schedule.casting_speed  ± 10 %    -5.0     +6.0"));
  EXPECT_THAT(text, HasSubstr("fails     -2.0"));
  EXPECT_THAT(text, HasSubstr("A small difference is known to ± 2.0 mm"));
  EXPECT_THAT(text, HasSubstr("This model does not respond to cooling.water.wetting.lag.\n"));
  EXPECT_THAT(text, HasSubstr("wet_coefficient = 1000 W/(m2 K): melts through at 43 s"));
  EXPECT_LE(widest_line(text), 100u) << text;
  EXPECT_THAT(render::sensitivity_page(sensitivity(), 0, 0.05), HasSubstr("melts through at 43 s"));
}

v1::StudyResult uncertainty() {
  v1::StudyResult result = sensitivity();
  v1::Spread& spread = *result.mutable_spread();
  spread.set_monitor("corner");
  spread.set_runs(8);
  for (const double t : {10.0, 250.0}) {
    spread.add_time_s(t);
    spread.add_cast_length_m(1e-3 * t);
    spread.add_low_m(1e-3 * (0.12 * t));
    spread.add_median_m(1e-3 * (0.16 * t));
    spread.add_high_m(1e-3 * (0.2 * t));
    spread.add_surface_error_m(1e-3);
    spread.add_index_time_s(t);
  }
  spread.set_inside_band(0.61);
  for (const double share : {0.1, 0.65, 0.001, 0.15, 0.1}) {
    v1::Spread::Share& shares = *spread.add_shares();
    for (int i = 0; i < 2; ++i) {
      shares.add_first(share);
      shares.add_total(share);
      shares.add_first_error(0.01);
      shares.add_total_error(0.02);
    }
  }
  return result;
}

TEST(UncertaintyText, AnswersHowSureAndWhatToMeasureFirst) {
  const std::string text = render::uncertainty_text(uncertainty(), 0.05);
  EXPECT_THAT(text, HasSubstr("9 of 10 castings have 30.0 to 50.0 mm at the corner"));
  EXPECT_THAT(text, HasSubstr("half of them less than 40.0 mm"));
  EXPECT_THAT(text, HasSubstr("Mesh and time steps add ± 2.0 mm."));
  EXPECT_THAT(text, HasSubstr("61 % of castings end inside the accepted band."));
  EXPECT_THAT(text, HasSubstr("65 ± 2 %     65 ± 4 %"));
  EXPECT_THAT(text, HasSubstr("Measure schedule.casting_speed first: were it known exactly, the "
                              "20.0 mm between 5 and 95 % would be\n11.8 mm."));
  EXPECT_THAT(text, HasSubstr("what the response surface does not follow"));
  EXPECT_THAT(text, HasSubstr("1 failed or cancelled"));
  EXPECT_LE(widest_line(text), 100u) << text;
  const std::string page = render::uncertainty_page(uncertainty(), 0.05);
  EXPECT_THAT(page, HasSubstr("data, 5 to 95 %"));
  EXPECT_THAT(page, HasSubstr("mesh and time steps"));
  EXPECT_THAT(page, HasSubstr("Runs that the figures do not rest on"));
}

TEST(UncertaintyText, NamesTheReasonForNoAnswer) {
  v1::StudyResult result = sensitivity();
  result.set_spread_fault("needs 40 runs");
  EXPECT_THAT(render::uncertainty_text(result, std::nullopt),
              HasSubstr("No answer yet: needs 40 runs"));
}

}  // namespace
}  // namespace dccast::client
