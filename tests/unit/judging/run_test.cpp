#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/judging/run_judgement.hpp"

namespace dccast::judging {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// Five steps of 50 s and 20 mm; the corner of a quarter slab rises evenly to 40 mm.
RunToJudge even_rise() {
  RunToJudge judged{.run = {{}, "run", {}}};
  v1::Case& description = judged.run.description;
  description.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  description.mutable_time()->set_end_s(250.0);
  description.mutable_plausibility()->set_least_curl_m(35e-3);
  description.mutable_plausibility()->set_greatest_curl_m(45e-3);

  for (int i = 1; i <= 5; ++i) {
    v1::StepReport& step = judged.run.steps.emplace_back();
    step.set_step(i);
    step.set_time_s(50.0 * i);
    step.set_time_step_s(50.0);
    step.set_cast_length_m(0.02 * i);
    step.set_contact_area_m2(0.01);
    step.set_sump_depth_m(0.05 * i);
    step.set_wetted_share(0.2 * i);
    step.mutable_section()->set_side_heat(1e5);
    step.mutable_section()->set_narrow_heat(5e4);
    step.mutable_section()->set_bottom_heat(5e4);

    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.set_curl_m(8e-3 * i);
    corner.set_judged(true);
  }
  return judged;
}

/// The errors of every curl, relative to it.
void set_errors(double lower, double upper, JudgedRun& run) {
  for (v1::StepReport& step : run.steps)
    for (v1::MonitorValue& monitor : *step.mutable_monitors()) {
      monitor.set_curl_lower_error_m(lower * monitor.curl_m());
      monitor.set_curl_upper_error_m(upper * monitor.curl_m());
    }
}

/// A limit of the corner that rises evenly to these figures at 250 s.
void add_limit(double curl_m, double uncertainty_m, v1::StudyResult& study) {
  v1::CurlCurve& curve = *study.add_limits()->mutable_curve();
  curve.set_monitor("corner");
  for (int i = 1; i <= 5; ++i) {
    curve.add_time_s(50.0 * i);
    curve.add_cast_length_m(0.02 * i);
    curve.add_curl_m(0.2 * i * curl_m);
    curve.add_uncertainty_m(0.2 * i * uncertainty_m);
  }
}

std::vector<std::string> chart_keys(const v1::Judgement& judgement) {
  std::vector<std::string> keys;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_chart()) keys.push_back(part.chart().key());
  return keys;
}

v1::Chart chart(const v1::Judgement& judgement, const std::string& key) {
  const auto found = std::ranges::find(judgement.parts(), key,
                                       [](const auto& part) { return part.chart().key(); });
  EXPECT_NE(found, judgement.parts().end()) << key;
  return found == judgement.parts().end() ? v1::Chart() : found->chart();
}

double last_time_s(const v1::Judgement& judgement, const std::string& key) {
  const v1::Chart of_key = chart(judgement, key);
  return *of_key.lines(0).x().rbegin();
}

/// The corner's figure in the table of curls, the first part.
v1::Cell corner_cell(const v1::Judgement& judgement, const std::string& key) {
  const v1::Table& table = judgement.parts(0).table();
  for (int i = 0; i < table.columns_size(); ++i)
    if (table.columns(i).key() == key) return table.rows(0).cells(i);
  return {};
}

/// A curl that tends to 40 mm like exp(-time / 100 s), in steps of 10 s.
RunToJudge settling_rise(double end_s) {
  RunToJudge judged = even_rise();
  judged.run.steps.clear();
  judged.run.description.mutable_time()->set_end_s(end_s);
  for (int i = 1; 10.0 * i <= end_s; ++i) {
    v1::StepReport& step = judged.run.steps.emplace_back();
    step.set_step(i);
    step.set_time_s(10.0 * i);
    step.set_cast_length_m(0.01 * i);
    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.set_curl_m(40e-3 * (1.0 - std::exp(-0.1 * i)));
    corner.set_judged(true);
  }
  return judged;
}

TEST(JudgeRun, SaysHowFastTheCurlStillMovesAndHowMuchIsToCome) {
  EXPECT_THAT(judge_run(even_rise()).sentences(),
              Contains("The curl still rises by 0.16 mm/s at the end: a later time.end shows where "
                       "it ends."));
  // 40 mm exp(-2.5) = 3.3 mm
  EXPECT_THAT(
      judge_run(settling_rise(250.0)).sentences(),
      Contains("The curl still rises by 0.033 mm/s at the end: with nothing changed about 3.3 "
               "mm or more are to come."));
}

TEST(JudgeRun, ACurlThatSettledSaysSoWhereThatWasAsked) {
  RunToJudge judged = settling_rise(800.0);
  EXPECT_THAT(judge_run(judged).sentences(), Not(Contains(HasSubstr("still"))));
  judged.run.description.mutable_time()->set_settled_m_per_s(5e-6);
  EXPECT_THAT(judge_run(judged).sentences(),
              Contains("The curl has settled: it moved by less than 0.005 mm/s."));
}

TEST(JudgeRun, AMeanNamesItsMembers) {
  RunToJudge judged = settling_rise(250.0);
  v1::Monitor& mean = *judged.run.description.add_monitor();
  mean.set_name("corner");
  for (const char* member : {"left", "right"}) mean.add_of()->set_monitor(member);
  EXPECT_THAT(judge_run(judged).sentences(),
              Contains(HasSubstr("corner, a mean of left and right, has risen 36.7 mm")));
}

TEST(JudgeRun, OfASlabThatHasCooledDownNothingIsToCome) {
  RunToJudge judged = settling_rise(250.0);
  judged.run.description.mutable_time()->set_end_s(1000.0);  // it settled before
  judged.run.description.mutable_time()->set_cool_down_s(50.0);
  EXPECT_THAT(judge_run(judged).sentences(), Not(Contains(HasSubstr("to come"))));
  EXPECT_THAT(judge_run(judged).sentences(), Not(Contains(HasSubstr("off the block"))));

  judged.run.steps.back().set_off_block_curl_m(41.2e-3);
  judged.run.steps.back().set_saw_off_m(44.4e-3);
  EXPECT_THAT(judge_run(judged).sentences(),
              Contains("Cold and off the block, without its weight, that curl is 41.2 mm above the "
                       "plane that the butt rests on; the butt rises from it by up to 44.4 mm, "
                       "which are to be sawn off."));
}

TEST(JudgeRun, SaysHowTheCurlLiesInThePlantsBand) {
  RunToJudge judged = even_rise();
  const auto sentence = [&](double least_m, double greatest_m) {
    v1::Plausibility& band = *judged.run.description.mutable_plausibility();
    band.set_least_curl_m(least_m);
    band.set_greatest_curl_m(greatest_m);
    return judge_run(judged).sentences(0);
  };
  const std::string inside = sentence(35e-3, 45e-3);
  EXPECT_THAT(inside, HasSubstr("At 250 s, after 100 mm of casting, corner has risen 40.0 mm"));
  EXPECT_THAT(inside, HasSubstr("has not been measured: dccast convergence does that. It is inside "
                                "the plant's band, 35 to 45 mm."));
  EXPECT_THAT(sentence(10e-3, 20e-3), HasSubstr("It is above the plant's band"));
  EXPECT_THAT(sentence(50e-3, 60e-3), HasSubstr("It is below the plant's band"));

  set_errors(0.2, 0.2, judged.run);
  EXPECT_THAT(sentence(35e-3, 45e-3), HasSubstr("this run cannot decide"));
}

TEST(JudgeRun, SaysWhenTheCurlCameAndWhereTheHeatLeft) {
  RunToJudge judged = even_rise();
  judged.run.description.mutable_cooling()->mutable_water()->set_enabled(true);
  // A quarter of 40 mm is passed after 50 s, three quarters after 150 s.
  EXPECT_THAT(judge_run(judged).sentences(1),
              testing::AllOf(HasSubstr("between 50 s and 150 s, at 20 to 60 mm"),
                             HasSubstr("75 % of the heat left through the faces"),
                             HasSubstr("25 % through the bottom"),
                             HasSubstr("Water wetted 20 to 60 % of the side")));

  for (v1::StepReport& step : judged.run.steps) step.mutable_monitors(0)->set_curl_m(0.0);
  EXPECT_THAT(judge_run(judged).sentences(), SizeIs(1)) << "what has not curled has no cause";
}

TEST(JudgeRun, AnErrorWithOneSideIsShownSo) {
  RunToJudge judged = even_rise();
  set_errors(0.0, 0.14, judged.run);
  EXPECT_THAT(judge_run(judged).sentences(0), HasSubstr("leave -0 +5.6 mm of it uncertain"));

  set_errors(0.04, 0.04, judged.run);
  const v1::Judgement judgement = judge_run(judged);
  EXPECT_THAT(judgement.sentences(0), HasSubstr("leave ± 1.6 mm of it uncertain"));
  for (const char* const key : {"curl", "curl_by_length"}) {
    const v1::Chart curls = chart(judgement, key);
    EXPECT_NEAR(curls.lines(0).low(0), 0.96 * 8e-3, 1e-15);
    EXPECT_NEAR(curls.lines(0).high(4), 1.04 * 40e-3, 1e-15);
    EXPECT_EQ(curls.region().low(), 35e-3);
  }
}

TEST(JudgeRun, TheErrorReachesBeyondTheIntervalOfTheLimit) {
  RunToJudge judged = even_rise();
  add_limit(48e-3, 2.5e-3, judged.refinement);
  const v1::Judgement judgement = judge_run(judged);
  EXPECT_THAT(judgement.sentences(0), HasSubstr("leave ± 10.5 mm of it uncertain"));
  EXPECT_NEAR(corner_cell(judgement, "curl").upper_error(), 8e-3 + 2.5e-3, 1e-12);
  EXPECT_NEAR(corner_cell(judgement, "finest_mesh").value(), 48e-3, 1e-12);
  EXPECT_NEAR(corner_cell(judgement, "finest_mesh").lower_error(), 2.5e-3, 1e-12);
  judged.refinement.mutable_limits(0)->set_order(1.0);
  EXPECT_NEAR(corner_cell(judge_run(judged), "limit").value(), 48e-3, 1e-12);

  const v1::Chart::Line limit = chart(judgement, "curl").lines(1);
  EXPECT_EQ(limit.name(), "corner, limit of finer meshes");
  EXPECT_THAT(limit.x(), ElementsAre(50, 100, 150, 200, 250));
  EXPECT_NEAR(limit.low(4), 45.5e-3, 1e-12);
  EXPECT_NEAR(limit.high(4), 50.5e-3, 1e-12);
  EXPECT_NEAR(chart(judgement, "curl_by_length").lines(1).x(2), 0.06, 1e-12);

  judged.run.steps.back().set_time_s(300.0);
  EXPECT_THAT(judge_run(judged).sentences(0), HasSubstr("has not been measured"))
      << "after the end of the study";
}

TEST(JudgeRun, SaysWhereTheErrorComesFromOrHowToKnowIt) {
  const auto note = [](const RunToJudge& judged) {
    const v1::Judgement judgement = judge_run(judged);
    const auto found =
        std::ranges::find(judgement.parts(), "discretisation",
                          [](const v1::JudgementPart& part) { return part.table().key(); });
    return found == judgement.parts().end() ? "" : found->table().note();
  };
  RunToJudge judged = even_rise();
  EXPECT_THAT(note(judged), HasSubstr("this run stands alone. dccast convergence CASE shows it"));

  judged.refinement.mutable_study()->set_id("0f2b9a4e");
  judged.refinement.mutable_study()->mutable_refinement()->set_levels(3);
  judged.refinement.add_runs()->set_state(v1::SUCCEEDED);
  EXPECT_THAT(note(judged), HasSubstr("of its study 1 succeeded, two are needed. dccast "
                                      "convergence --study 0f2b9a4e"));

  set_errors(0.1, 0.1, judged.run);
  EXPECT_THAT(note(judged), HasSubstr("the band of the case's quality"));

  add_limit(48e-3, 2.5e-3, judged.refinement);
  judged.run.description.mutable_mesh()->set_refinement(2);
  EXPECT_THAT(note(judged), HasSubstr("This run has refinement 2."));
}

TEST(JudgeRun, FiguresBeyondValidityAreNoAnswer) {
  RunToJudge judged = even_rise();
  judged.valid_until_s = 200.0;
  const v1::Judgement judgement = judge_run(judged);
  EXPECT_THAT(judgement.sentences(),
              ElementsAre("The run has no curl: it is not valid from 200 s on, after 80 mm of "
                          "casting."));
  EXPECT_EQ(judgement.parts(0).table().key(), "end") << "no table of curls";
  EXPECT_THAT(judgement.parts(0).table().note(), HasSubstr("beyond validity"));
  EXPECT_EQ(chart(judgement, "curl").beyond_x(), 200.0);
  EXPECT_EQ(chart(judgement, "curl_by_length").beyond_x(), 0.08);
}

TEST(JudgeRun, ARunThatFailedHasNoCurl) {
  RunToJudge judged = even_rise();
  judged.run.failed = true;
  const v1::Judgement judgement = judge_run(judged);
  EXPECT_THAT(judgement.sentences(),
              ElementsAre("The run has no curl: it failed at 250 s, after 100 mm of casting."));
  EXPECT_EQ(judgement.parts(0).table().key(), "end") << "no table of curls";
  EXPECT_FALSE(chart(judgement, "curl").lines().empty()) << "its course is shown";
}

TEST(JudgeRun, HeatIsSummedFromTheStart) {
  const v1::Judgement judgement = judge_run(even_rise());
  const v1::Chart heat = chart(judgement, "heat");
  ASSERT_THAT(heat.lines(), SizeIs(3)) << "lines that are zero throughout are left out";
  EXPECT_EQ(heat.lines(0).name(), "out: wide face");
  EXPECT_EQ(heat.lines(0).y(0), 1e5 * 50.0);
  EXPECT_EQ(heat.lines(0).y(4), 1e5 * 250.0);
  EXPECT_EQ(heat.y().unit(), "J");
  EXPECT_THAT(chart_keys(judgement), Contains("contact"));
  EXPECT_THAT(chart_keys(judgement), Not(Contains("shell"))) << "all of it is zero";
}

TEST(JudgeRun, TheChartOfTheShellHasItsLimit) {
  RunToJudge judged = even_rise();
  for (v1::StepReport& step : judged.run.steps) step.set_least_shell_m(0.02);
  EXPECT_FALSE(chart(judge_run(judged), "shell").has_region()) << "the case has no limit";
  judged.run.description.mutable_plausibility()->set_minimum_shell_m(5e-3);
  const v1::Chart shell = chart(judge_run(judged), "shell");
  EXPECT_EQ(shell.region().low(), 5e-3);
  EXPECT_EQ(shell.region().name(), "5 mm or more");
}

TEST(JudgeRun, SpeedAndWaterAreThoseOfTheRun) {
  RunToJudge judged = even_rise();
  v1::Schedule& recipe = *judged.run.description.mutable_schedule();
  recipe.mutable_casting_speed_m_per_s()->add_value(1e-3);
  recipe.mutable_casting_speed_factor()->add_value(0.5);
  recipe.mutable_water_flow_m2_per_s()->add_value(3e-3);
  v1::Water& water = *judged.run.description.mutable_cooling()->mutable_water();
  water.set_enabled(true);
  water.set_start_s(100.0);
  judged.run.steps[0].set_time_s(-50.0);

  const v1::Judgement judgement = judge_run(judged);
  EXPECT_THAT(chart(judgement, "casting_speed").lines(0).y(),
              ElementsAre(0.0, 0.5e-3, 0.5e-3, 0.5e-3, 0.5e-3));
  EXPECT_THAT(chart(judgement, "water").lines(0).y(), ElementsAre(0.0, 0.0, 3e-3, 3e-3, 3e-3))
      << "the step that ends when the water starts is dry";
}

TEST(JudgeRun, EveryChartIsExplained) {
  const v1::Judgement judgement = judge_run(even_rise());
  for (const v1::JudgementPart& part : judgement.parts()) {
    if (!part.has_chart()) continue;
    EXPECT_NE(part.chart().note(), "") << part.chart().key();
  }
}

TEST(JudgeRun, SpeedAndWaterEndWithTheCasting) {
  RunToJudge judged = even_rise();
  for (const char* const key : {"casting_speed", "water"})
    EXPECT_EQ(last_time_s(judge_run(judged), key), 250.0) << key;

  // From 150 s on the slab cools down: it is neither cast nor sprayed.
  judged.run.description.mutable_time()->set_end_s(150.0);
  for (const char* const key : {"casting_speed", "water"})
    EXPECT_EQ(last_time_s(judge_run(judged), key), 150.0) << key;
}

/// A gauge at the corner with 51 readings, of which one was left out.
FollowedCasting followed_corner() {
  FollowedCasting followed;
  v1::ForecastCurl& curl = *followed.forecast.add_curls();
  curl.set_monitor("corner");
  curl.set_readings(50);
  curl.set_left_out(1);
  curl.add_measured_time_s(200.0);
  curl.add_measured_m(31e-3);

  // Errors of 1 and 2 mm, the second outside the band of 1.5 mm.
  followed.past.push_back({.monitor = "corner",
                           .ahead_s = 60.0,
                           .time_s = {100.0, 200.0},
                           .measured_m = {11e-3, 31e-3},
                           .expected_m = {10e-3, 29e-3},
                           .lower_m = {8.5e-3, 27.5e-3},
                           .upper_m = {11.5e-3, 30.5e-3}});
  return followed;
}

const v1::Table* find_table(const v1::Judgement& judgement, const std::string& key) {
  for (const auto& part : judgement.parts())
    if (part.has_table() && part.table().key() == key) return &part.table();
  return nullptr;
}

TEST(FollowedRun, ShowsWhatWasCastBesideThePlan) {
  RunToJudge judged = even_rise();
  judged.followed = followed_corner();
  judged.followed->poured = {{.name = "water",
                              .planned = "120 l/min/m",
                              .measured = "90 l/min/m",
                              .range = "60 l/min/m to 120 l/min/m"}};
  judged.followed->has_findings = true;
  const v1::Judgement judgement = judge_run(judged);

  const v1::Table* const poured = find_table(judgement, "poured");
  ASSERT_NE(poured, nullptr);
  ASSERT_EQ(poured->rows_size(), 1);
  EXPECT_EQ(poured->rows(0).cells(1).text(), "90 l/min/m");
  EXPECT_EQ(poured->rows(0).cells(3).text(), "120 l/min/m");
  EXPECT_EQ(find_table(judgement, "recipe")->heading(), "plan");
  EXPECT_THAT(find_table(judgement, "forecast")->note(), testing::Not(HasSubstr("No warning")));
  EXPECT_EQ(find_table(judge_run(even_rise()), "recipe")->heading(), "recipe");
}

TEST(FollowedRun, ComparesForecastAndReadings) {
  RunToJudge judged = even_rise();
  judged.followed = followed_corner();
  const v1::Judgement judgement = judge_run(judged);

  const v1::Table* table = find_table(judgement, "forecast");
  ASSERT_NE(table, nullptr);
  const auto& cells = table->rows(0).cells();
  EXPECT_EQ(cells[0].text(), "corner");
  EXPECT_EQ(cells[1].value(), 60.0);
  EXPECT_EQ(cells[2].value(), 2.0);
  EXPECT_NEAR(cells[3].value(), std::sqrt(2.5) * 1e-3, 1e-12);
  EXPECT_EQ(cells[4].value(), 0.5);
  EXPECT_THAT(table->note(), HasSubstr("corner: 50 readings were used and 1 left out"));
  EXPECT_THAT(table->note(), HasSubstr("No warning was raised"));
  EXPECT_EQ(find_table(judgement, "warnings"), nullptr);

  const auto chart = std::ranges::find_if(judgement.parts(), [](const v1::JudgementPart& part) {
    return part.chart().key() == "forecast";
  });
  ASSERT_NE(chart, judgement.parts().end());
  const auto& lines = chart->chart().lines();
  ASSERT_EQ(lines.size(), 3);
  EXPECT_TRUE(lines[0].is_dotted());
  EXPECT_EQ(lines[1].y_size(), 5) << "computed";
  EXPECT_EQ(lines[2].name(), "forecast 60 s before");
  EXPECT_EQ(lines[2].low(1), 27.5e-3);
}

TEST(FollowedRun, ListsWarningsWithTheirTimes) {
  RunToJudge judged = even_rise();
  judged.followed = followed_corner();
  v1::ForecastWarning& warning = *judged.followed->forecast.add_warnings();
  warning.set_time_s(80.0);
  warning.set_monitor("corner");
  warning.set_text("above what is permitted");
  for (const char* cause : {"water", "metal temperature"}) warning.add_causes(cause);

  const v1::Judgement judgement = judge_run(judged);
  const v1::Table* table = find_table(judgement, "warnings");
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(table->rows(0).cells(0).value(), 80.0);
  EXPECT_EQ(table->rows(0).cells(3).text(), "water, metal temperature");
}

TEST(FollowedRun, HasNoErrorsOfACastingThatWasTooShort) {
  RunToJudge judged = even_rise();
  judged.followed = followed_corner();
  judged.followed->past = {{.monitor = "corner", .ahead_s = 60.0}};
  const v1::Judgement judgement = judge_run(judged);
  const auto& cells = find_table(judgement, "forecast")->rows(0).cells();
  EXPECT_EQ(cells[2].value(), 0.0);
  EXPECT_FALSE(cells[3].has_value());
  EXPECT_FALSE(cells[4].has_value());
}

TEST(FollowedRun, SaysWhyThereIsNoForecast) {
  RunToJudge judged = even_rise();
  judged.followed = FollowedCasting{.no_forecast = "job 1 measures no curl"};
  const v1::Judgement judgement = judge_run(judged);
  const v1::Table* table = find_table(judgement, "forecast");
  ASSERT_NE(table, nullptr);
  EXPECT_TRUE(table->rows().empty());
  EXPECT_EQ(table->note(), "No forecast: job 1 measures no curl.");
}

}  // namespace
}  // namespace dccast::judging
