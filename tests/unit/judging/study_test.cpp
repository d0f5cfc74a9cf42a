#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "proto/case_file/quality.hpp"
#include "proto/case_file/study_keys.hpp"
#include "server/judging/judged_study.hpp"
#include "tests/support/judged_table.hpp"
#include "tests/support/study_result.hpp"

namespace dccast::judging {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using support::add_axis, support::add_run, support::table_of;

v1::StudyResult sensitivity() {
  v1::StudyResult result;
  result.mutable_study()->mutable_sweep()->set_purpose(v1::SweepPlan::SENSITIVITY);
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
  lost.mutable_failure()->set_kind(v1::Finding::SHELL_MELTED_THROUGH);
  lost.mutable_failure()->set_message("melts through at 43 s");
  lost.set_end_curl_m(0, std::numeric_limits<double>::quiet_NaN());
  add_run(result, 3, 1, 38.0);
  return result;
}

/// Texts and codes of a row; numbers in tenths of a thousandth.
std::vector<std::string> texts_of(const v1::Table::Row& row) {
  std::vector<std::string> texts;
  for (const v1::Cell& cell : row.cells())
    texts.push_back(!cell.text().empty()   ? cell.text()
                    : !cell.code().empty() ? cell.code()
                    : cell.has_value()     ? std::to_string(std::lround(1e4 * cell.value()))
                                           : "");
  return texts;
}

v1::Judgement judged(v1::StudyResult result, std::optional<double> difference_error) {
  return judge_study({std::move(result), 0, difference_error});
}

TEST(Sensitivity, EffectsAreDifferencesToTheCaseItselfLeversFirstThenLargestFirst) {
  const v1::Table effects = table_of(judged(sensitivity(), 0.05), "effects");
  ASSERT_EQ(effects.rows_size(), 4);
  EXPECT_THAT(texts_of(effects.rows(0)), ElementsAre("lever", "schedule.casting_speed", "± 10 %",
                                                     "-50", "60", "schedule.casting_speed.scale"));
  EXPECT_THAT(texts_of(effects.rows(1)),
              ElementsAre("datum", "cooling.bottom_block.wet_coefficient", "1000..3000 W/(m2 K)",
                          "fails", "-20", "cooling.bottom_block.wet_coefficient"));
  EXPECT_TRUE(effects.columns(3).has_bars());
  const v1::Table base = table_of(judged(sensitivity(), 0.05), "case_itself");
  EXPECT_DOUBLE_EQ(base.rows(0).cells(1).value(), 40e-3);
  EXPECT_DOUBLE_EQ(base.rows(0).cells(2).value(), 2e-3);
}

TEST(Sensitivity, OfAStudyWithoutTheCaseItselfIsUnknown) {
  v1::StudyResult result = sensitivity();
  result.mutable_runs()->erase(result.runs().begin());  // its job was deleted
  const v1::Judgement judgement = judged(result, 0.05);
  EXPECT_THAT(judgement.sentences(), ElementsAre(HasSubstr("nothing to compare with")));
  EXPECT_EQ(table_of(judgement, "effects").rows_size(), 0);
}

TEST(Sensitivity, AnErrorThatWasNotMeasuredIsNotStated) {
  const v1::Judgement judgement = judged(sensitivity(), std::nullopt);
  EXPECT_THAT(judgement.sentences(),
              Contains(HasSubstr("error of a difference has not been measured for such a case")));
  EXPECT_THAT(judgement.sentences(), Not(Contains(HasSubstr("is known to"))));
  EXPECT_FALSE(table_of(judgement, "case_itself").rows(0).cells(2).has_value());
}

TEST(Sensitivity, StatesLeversDataFailuresAndWhatDoesNotMatter) {
  const v1::Judgement judgement = judged(sensitivity(), 0.05);
  EXPECT_THAT(judgement.heading(), HasSubstr("9 runs: 8 valid, 1 failed or cancelled"));
  EXPECT_THAT(table_of(judgement, "responding").heading(), HasSubstr("corner at the end: 40.0 mm"));
  EXPECT_EQ(table_of(judgement, "responding").rows_size(), 3);
  EXPECT_THAT(judgement.sentences(),
              ElementsAre(HasSubstr("A small difference is known to ± 2.0 mm"),
                          "This model does not respond to cooling.water.wetting.lag."));

  const v1::Table lost = table_of(judgement, "lost_runs");
  ASSERT_EQ(lost.rows_size(), 1);
  EXPECT_THAT(texts_of(lost.rows(0)),
              Contains("cooling.bottom_block.wet_coefficient = 1000 W/(m2 K)"));
  EXPECT_THAT(texts_of(lost.rows(0)), Contains("shell_melted_through"));
  EXPECT_THAT(texts_of(lost.rows(0)), Contains("melts through at 43 s"));
}

TEST(Judgement, AMonitorIsNamedOrHasTheLargestCurl) {
  EXPECT_EQ(monitor_of(sensitivity(), "centre"), 1);
  EXPECT_EQ(monitor_of(sensitivity(), "edge"), -1);
  EXPECT_EQ(monitor_of(sensitivity(), ""), 0);
}

TEST(Judgement, RangesReadAsTheyAreWritten) {
  v1::StudyResult result = sensitivity();
  add_axis(result, "schedule.casting_temperature.offset", "-3 K", "3 K");
  add_axis(result, "cooling.bottom_block.gap_coefficient.scale", "0.67", "1");
  const auto& axes = result.study().sweep().axes();
  EXPECT_EQ(case_file::range_of(axes[0]), "± 3 %");
  EXPECT_EQ(case_file::range_of(axes[2]), "0.5..5 s");
  EXPECT_EQ(case_file::range_of(axes[3]), "1000..3000 W/(m2 K)");
  EXPECT_EQ(case_file::range_of(axes[4]), "± 3 K");
  EXPECT_EQ(case_file::range_of(axes[5]), "0.67..1 times");
}

v1::StudyResult uncertainty() {
  v1::StudyResult result = sensitivity();
  result.mutable_study()->mutable_sweep()->set_purpose(v1::SweepPlan::UNCERTAINTY);
  for (v1::StudyRun& run : *result.mutable_runs()) {
    run.mutable_mesh_error()->set_lower(0.05);
    run.mutable_mesh_error()->set_upper(0.05);
    case_file::set_end_errors(v1::Case(), run.end_curl_m(), run);
  }
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

/// Lets the runs of a study end as they are named; the others go to their end.
v1::StudyResult with_ends(v1::StudyResult result, const std::vector<std::string>& codes) {
  for (v1::StudyRun& run : *result.mutable_runs()) {
    run.set_state(v1::SUCCEEDED);
    run.clear_failure();
  }
  for (std::size_t i = 0; i < codes.size(); ++i) {
    v1::StudyRun& run = *result.mutable_runs(static_cast<int>(i));
    if (codes[i] == "beyond_validity") {
      run.set_beyond_validity(true);
      continue;
    }
    run.set_state(v1::FAILED);
    if (codes[i] != "worker_lost") run.mutable_failure()->set_code(codes[i]);
  }
  return result;
}

TEST(Uncertainty, CountsCastingsThatAreLost) {
  const int runs = uncertainty().runs_size();
  ASSERT_GE(runs, 6);
  const v1::Judgement none = judged(with_ends(uncertainty(), {}), std::nullopt);
  EXPECT_THAT(none.sentences(0), HasSubstr("9 of 10 castings have"));
  EXPECT_THAT(none.sentences(), Contains("61 % of castings end inside the accepted band."));

  const v1::Judgement judgement =
      judged(with_ends(uncertainty(),
                       {"bleed_out", "shell_melted_through", "beyond_validity", "worker_lost"}),
             std::nullopt);
  EXPECT_EQ(judgement.sentences(0),
            fmt::format("Of {} castings 2 bled out, melted through or turned, 1 ended beyond "
                        "validity, 1 could not be computed.",
                        runs));
  EXPECT_THAT(judgement.sentences(1), HasSubstr("9 of 10 of the others have 30.0 to 50.0 mm"));
  // Of what could not be computed nothing is known; the others that are lost end in no band.
  EXPECT_THAT(judgement.sentences(),
              Contains(fmt::format("{:.0f} % of all castings end inside the accepted band.",
                                   61.0 * (runs - 4) / (runs - 1))));
  EXPECT_EQ(table_of(judgement, "lost_runs").rows_size(), 4);
}

TEST(Uncertainty, AnswersHowSureAndWhatToMeasureFirst) {
  const v1::Judgement judgement = judged(uncertainty(), std::nullopt);
  EXPECT_THAT(judgement.sentences(1), AllOf(HasSubstr("9 of 10 of the others have 30.0 to 50.0 mm"),
                                            HasSubstr("half of them less than 40.0 mm")));
  EXPECT_THAT(judgement.sentences(), Contains("Mesh and time steps add ± 2.0 mm."));
  EXPECT_THAT(judgement.sentences(),
              Contains("Measure schedule.casting_speed first: were it known exactly, the 20.0 mm "
                       "between 5 and 95 % would be 11.8 mm."));
  EXPECT_THAT(judgement.heading(), HasSubstr("1 failed or cancelled (1 shell melted through)"));

  const v1::Table shares = table_of(judgement, "shares");
  EXPECT_EQ(shares.rows(0).cells(0).text(), "schedule.casting_speed");
  EXPECT_DOUBLE_EQ(shares.rows(0).cells(2).value(), 0.65);
  EXPECT_DOUBLE_EQ(shares.rows(0).cells(2).upper_error(), 0.02);
  EXPECT_DOUBLE_EQ(shares.rows(0).cells(3).upper_error(), 0.04);
  EXPECT_EQ(shares.rows().rbegin()->cells(0).text(), "what the response surface does not follow");
  EXPECT_EQ(shares.note(), "1 more data, with less than these");
  EXPECT_EQ(table_of(judgement, "lost_runs").rows_size(), 1);

  for (const v1::JudgementPart& part : judgement.parts()) {
    if (part.chart().key() != "curl") continue;
    EXPECT_EQ(part.chart().lines(0).name(), "data, 5 to 95 %");
    EXPECT_EQ(part.chart().lines(1).name(), "mesh and time steps");
    EXPECT_NEAR(part.chart().lines(1).high(1), 0.042, 1e-12);
  }
}

TEST(Uncertainty, NamesTheReasonForNoAnswer) {
  v1::StudyResult result = sensitivity();
  result.mutable_study()->mutable_sweep()->set_purpose(v1::SweepPlan::UNCERTAINTY);
  result.set_spread_fault("needs 40 runs");
  EXPECT_EQ(*judged(result, std::nullopt).sentences().rbegin(),
            "The study has no answer: needs 40 runs");
  result.mutable_runs(0)->set_state(v1::RUNNING);
  EXPECT_EQ(*judged(result, std::nullopt).sentences().rbegin(), "No answer yet: needs 40 runs");
}

TEST(Runs, AreListedWithTheErrorOfMeshAndStepsWhereItIsKnown) {
  v1::StudyResult result;
  result.add_monitors("corner");
  add_axis(result, "mesh.rows", "10", "20");
  v1::StudyRun& run = add_run(result, 0, 0, -40.0);
  run.mutable_mesh_error()->set_upper(0.05);
  case_file::set_end_errors(v1::Case(), run.end_curl_m(), run);
  add_run(result, 0, 1, 41.0);
  const v1::Table runs = table_of(judged(result, std::nullopt), "runs");
  EXPECT_TRUE(runs.columns(2).has_error());
  EXPECT_NEAR(runs.rows(0).cells(2).lower_error(), 2e-3, 1e-12) << "below zero more is down";
  EXPECT_EQ(runs.rows(0).cells(2).upper_error(), 0.0);
  EXPECT_FALSE(runs.rows(1).cells(2).has_upper_error());
  EXPECT_DOUBLE_EQ(runs.columns(2).resolution(), 1e-4) << "an error of 2 mm has two digits";
  EXPECT_EQ(runs.rows(1).cells(5).code(), "succeeded");
  result.mutable_runs(0)->clear_end_upper_error_m();
  EXPECT_FALSE(table_of(judged(result, std::nullopt), "runs").columns(2).has_error());
}

TEST(Refinement, LimitsHaveTheirErrorAndWhereItIsLargest) {
  v1::StudyResult result;
  result.mutable_study()->mutable_refinement();
  result.add_monitors("corner");
  result.set_valid_until_s(15.0);
  v1::StudyResult::Limit& limit = *result.add_limits();
  limit.set_order(0.9);
  limit.mutable_curve()->set_monitor("corner");
  for (const double t : {10.0, 20.0}) {
    limit.mutable_curve()->add_time_s(t);
    limit.mutable_curve()->add_curl_m(1e-3 * t);
    limit.mutable_curve()->add_uncertainty_m(t < 15 ? 3e-3 : 1e-3);
  }
  const v1::Table limits = table_of(judged(result, std::nullopt), "limits");

  ASSERT_EQ(limits.rows_size(), 1);
  EXPECT_DOUBLE_EQ(limits.rows(0).cells(2).value(), 20e-3);
  EXPECT_DOUBLE_EQ(limits.rows(0).cells(2).upper_error(), 1e-3);
  EXPECT_DOUBLE_EQ(limits.rows(0).cells(3).value(), 3e-3);
  EXPECT_DOUBLE_EQ(limits.rows(0).cells(4).value(), 10.0);
  EXPECT_THAT(limits.note(), HasSubstr("beyond validity: from 15.00 s on"));
}

TEST(Refinement, StatesLimitsAndLevelsThatAreLeftOut) {
  v1::StudyResult result;
  result.mutable_study()->mutable_refinement();
  EXPECT_THAT(judged(result, std::nullopt).sentences(),
              ElementsAre("No limit yet: two levels that succeeded are needed."));

  for (const char* monitor : {"corner", "centre"}) {
    v1::StudyResult::Limit& limit = *result.add_limits();
    limit.mutable_curve()->set_monitor(monitor);
    limit.mutable_curve()->add_time_s(4.0);
    limit.mutable_curve()->add_curl_m(4.8e-3);
    limit.mutable_curve()->add_uncertainty_m(0.25e-3);
  }
  result.mutable_limits(0)->set_order(1.0);
  v1::StudyRun& lost = *result.add_runs();
  lost.set_refinement(4);
  lost.set_state(v1::FAILED);
  lost.mutable_failure()->set_kind(v1::Finding::SOLVE_FAILED);
  lost.mutable_failure()->set_message("did not converge");
  EXPECT_THAT(
      judged(result, std::nullopt).sentences(),
      ElementsAre("The curl of the corner at the end tends to 4.800 ± 0.250 mm, with order 1.00.",
                  "The curl of the centre at the end is 4.800 ± 0.250 mm by the finest level: it "
                  "does not converge with an order.",
                  "Refinement 4 is left out: solve failed: did not converge."));
}

/// The charts of a judgement.
std::vector<v1::Chart> charts_of(const v1::Judgement& judgement) {
  std::vector<v1::Chart> charts;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_chart()) charts.push_back(part.chart());
  return charts;
}

/// Runs at every speed with every number of rows.
v1::StudyResult grid(int rows) {
  v1::StudyResult result;
  result.add_monitors("corner");
  add_axis(result, "schedule.casting_speed", "0.001 m/s", "0.002 m/s");
  add_axis(result, "mesh.rows", "1", std::to_string(rows));
  for (int row = 1; row <= rows; ++row)
    for (const double speed : {0.002, 0.001}) {
      v1::StudyRun& run = *result.add_runs();
      run.set_state(v1::SUCCEEDED);
      run.add_values(std::to_string(speed) + " m/s");
      run.add_values(std::to_string(row));
      run.add_numbers(speed);
      run.add_numbers(row);
      run.add_end_curl_m(speed * row);
    }
  return result;
}

TEST(Sweep, HasTheCurlAgainstEachKeyWithALineForEachValueOfTheOthers) {
  const auto charts = charts_of(judged(grid(2), std::nullopt));
  ASSERT_EQ(charts.size(), 3u);
  EXPECT_EQ(charts[0].heading(), "curl of the corner at the end against schedule.casting_speed");
  EXPECT_EQ(charts[0].x().unit(), "m/s");
  ASSERT_EQ(charts[0].lines_size(), 2);
  EXPECT_EQ(charts[0].lines(1).name(), "2");
  EXPECT_THAT(charts[0].lines(1).x(), ElementsAre(0.001, 0.002));
  EXPECT_THAT(charts[0].lines(1).y(), ElementsAre(0.002, 0.004));
}

TEST(Sweep, HasDotsWhereLinesWouldBeTooMany) {
  const auto charts = charts_of(judged(grid(7), std::nullopt));
  ASSERT_EQ(charts.size(), 3u);
  ASSERT_EQ(charts[0].lines_size(), 1);
  EXPECT_TRUE(charts[0].lines(0).is_dotted());
  EXPECT_EQ(charts[0].lines(0).x_size(), 14);

  // Against two keys, the curl is the colour: a line for each class of it.
  ASSERT_EQ(charts[2].lines_size(), 5);
  EXPECT_EQ(charts[2].y().quantity(), "mesh.rows");
  EXPECT_EQ(charts[2].lines(4).name(), "10.0 to 14.0 mm");
  EXPECT_TRUE(charts[2].lines(4).is_dotted());
}

}  // namespace
}  // namespace dccast::judging
