#include "server/studies/curl_forecast.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/shaped_castings.hpp"

namespace dccast::studies {
namespace {

TEST(CurlForecast, HasWhatTheGaugeHasShown) {
  const auto curl = forecast(ensemble(21), readings(1.0, 50.0));
  ASSERT_EQ(curl.measured_m_size(), 51);
  EXPECT_EQ(curl.measured_time_s(50), 50.0);
  EXPECT_EQ(curl.measured_m(50), shape(50.0));
}

TEST(CurlForecast, IsTheMeanOfTheRunsBeforeAnythingIsMeasured) {
  const auto curl = forecast(ensemble(21), {});
  EXPECT_EQ(curl.members(), 21);
  EXPECT_EQ(curl.time_s(0), 0.0);
  EXPECT_EQ(*curl.time_s().rbegin(), end_s);
  EXPECT_NEAR(*curl.curl_m().rbegin(), shape(end_s), 1e-12);
  EXPECT_GT(width_at_end(curl), 0.3 * shape(end_s));
}

TEST(CurlForecast, TendsToTheCastingThatIsMeasured) {
  const auto before = forecast(ensemble(21), {});
  const auto curl = forecast(ensemble(21), readings(1.15, 50.0));
  EXPECT_EQ(curl.readings(), 51) << "from the start of the block on";
  EXPECT_EQ(curl.left_out(), 0);
  EXPECT_EQ(curl.time_s(0), 50.0);
  EXPECT_NEAR(*curl.curl_m().rbegin(), 1.15 * shape(end_s), 0.5 * width_at_end(curl));
  EXPECT_NEAR(curl.curl_m(0), 1.15 * shape(50.0), 0.5e-3);
  EXPECT_LT(width_at_end(curl), 0.5 * width_at_end(before));
}

TEST(CurlForecast, LeavesOutWhatNoCastingShows) {
  auto measured = readings(1.1, 50.0);
  measured[40].mutable_curls(0)->set_curl_m(0.5);
  const auto curl = forecast(ensemble(21), measured);
  EXPECT_EQ(curl.left_out(), 1);
  EXPECT_NEAR(curl.curl_m(0), 1.1 * shape(50.0), 0.5e-3);
}

TEST(CurlForecast, TakesTheErrorOfTheMeshIntoMeanAndBand) {
  const auto plain = forecast(ensemble(21), {});
  const auto moved = forecast(with_band(ensemble(21)), {});
  EXPECT_NEAR(*moved.curl_m().rbegin(), 1.03 * *plain.curl_m().rbegin(), 1e-12);
  EXPECT_GT(width_at_end(moved), width_at_end(plain));
}

TEST(CurlForecast, CountsOnlyRunsThatSucceededAndStayedValid) {
  v1::StudyResult runs = ensemble(20);
  runs.mutable_runs(3)->set_state(v1::FAILED);
  runs.mutable_runs(4)->set_beyond_validity(true);
  EXPECT_EQ(forecast(runs, {}).members(), 18);

  try {
    forecast(ensemble(fewest_members - 1), {});
    FAIL();
  } catch (const CannotForecast& reason) {
    EXPECT_THAT(reason.what(), ::testing::HasSubstr("15 runs of study study count so far, 16"));
  }
}

/// Finer runs of the first members, whose curls are larger by a share of the shape that grows from
/// one to the next.
v1::StudyResult finer(const v1::StudyResult& runs, int pairs, double first, double growth) {
  v1::StudyResult fine;
  for (int i = 0; i < pairs; ++i) {
    v1::StudyRun& run = *fine.add_runs() = runs.runs(i);
    v1::CurlCurve& curve = *run.mutable_curves(0);
    for (int k = 0; k < curve.time_s_size(); ++k)
      curve.set_curl_m(k, curve.curl_m(k) + (first + growth * i) * shape(curve.time_s(k)));
  }
  // The order of a study is its own.
  std::reverse(fine.mutable_runs()->begin(), fine.mutable_runs()->end());
  return fine;
}

TEST(CurlForecast, PairsTellTheErrorOfTheMesh) {
  const v1::StudyResult runs = with_band(ensemble(21));
  const auto plain = forecast(ensemble(21), {});

  // Misfits of 10, 11 and 12 %: their mean moves the curl, their scatter widens the band.
  const v1::StudyResult fine = finer(ensemble(21), 3, 0.10, 0.01);
  const auto paired = forecast(runs, {}, fine);
  EXPECT_NEAR(*paired.curl_m().rbegin(), 1.11 * shape(end_s), 1e-12);
  const double scatter = 0.01 * shape(end_s), sd = width_at_end(plain) / 2.0 / 1.645;
  EXPECT_NEAR(width_at_end(paired), 2.0 * 1.645 * std::hypot(sd, scatter), 1e-9)
      << "and the band of the members is not added";
}

TEST(CurlForecast, WhatTheFinerQualityLeavesIsInTheBandToo) {
  const v1::StudyResult runs = ensemble(21), fine = finer(runs, 3, 0.10, 0.01);
  const auto paired = forecast(runs, {}, fine), banded = forecast(runs, {}, with_band(fine));
  EXPECT_NEAR(*banded.curl_m().rbegin(), 1.03 * *paired.curl_m().rbegin(), 1e-12);
  EXPECT_GT(width_at_end(banded), width_at_end(paired));
}

TEST(CurlForecast, OnePairIsNone) {
  const v1::StudyResult runs = with_band(ensemble(21));
  v1::StudyResult two = finer(runs, 2, 0.10, 0.0);
  two.mutable_runs(0)->set_values(0, "99 W/m/K");  // of no member
  const auto by_band = forecast(runs, {});
  EXPECT_EQ(*forecast(runs, {}, two).curl_m().rbegin(), *by_band.curl_m().rbegin());

  two = finer(runs, 2, 0.10, 0.0);
  two.mutable_runs(1)->set_state(v1::FAILED);
  EXPECT_EQ(*forecast(runs, {}, two).curl_m().rbegin(), *by_band.curl_m().rbegin());
}

TEST(CurlForecast, WarnsOfASlippedGaugeAndOfACastingThatIsNotAsPlanned) {
  EXPECT_THAT(whole_forecast(ensemble(21), faulty(0.0, 0.0)).warnings(), ::testing::IsEmpty());

  const auto slipped = whole_forecast(ensemble(21), faulty(4e-3, 0.0));
  ASSERT_EQ(slipped.warnings_size(), 1);
  EXPECT_EQ(slipped.warnings(0).monitor(), "corner");
  EXPECT_LT(slipped.warnings(0).time_s(), 66.0);
  EXPECT_THAT(slipped.warnings(0).text(), ::testing::HasSubstr("from 60 s on the gauge shows"));
  EXPECT_THAT(slipped.warnings(0).causes(), ::testing::ElementsAre("the gauge has slipped"));

  const auto drifting = whole_forecast(ensemble(21), faulty(0.0, -0.3e-3));
  ASSERT_GE(drifting.warnings_size(), 1);
  EXPECT_THAT(drifting.warnings(0).text(), ::testing::HasSubstr("mm below"));
  EXPECT_THAT(drifting.warnings(0).causes(),
              ::testing::ElementsAre("water", "metal temperature", "casting speed"));
}

/// A sound casting as a gauge with a wrong scale or sign shows it.
std::vector<v1::Reading> misread(double casting, double scale) {
  auto made = readings(casting, 100.0);
  for (v1::Reading& reading : made) {
    v1::MeasuredCurl& curl = *reading.mutable_curls(0);
    curl.set_curl_m(scale * curl.curl_m());
  }
  return made;
}

TEST(CurlForecast, TellsAGaugeOfWrongScaleOrSignByTheForecastBeforeTheCasting) {
  const auto before = forecast(ensemble(21), {});
  for (const auto& [scale, mistake] : {std::pair{-1.0, "its sign is turned"},
                                       {10.0, "ten times too large"},
                                       {0.1, "a tenth"},
                                       {-0.1, "a tenth, its sign turned"},
                                       {25.4, "what is read as inches is in mm"},
                                       {1.0 / 25.4, "what is read as mm is in inches"},
                                       {1000.0, "what is read as m is in mm"}})
    for (const double casting : {0.85, 1.0, 1.15}) {
      const auto found = whole_forecast(ensemble(21), misread(casting, scale));
      ASSERT_EQ(found.warnings_size(), 1) << scale << " of " << casting;
      EXPECT_THAT(found.warnings(0).causes(0), ::testing::HasSubstr(mistake));
      EXPECT_LT(found.warnings(0).time_s(), 60.0) << scale << " of " << casting;
      EXPECT_EQ(found.curls(0).readings(), 0);
      EXPECT_EQ(found.curls(0).left_out(), 101);
      EXPECT_EQ(*found.curls(0).curl_m().rbegin(), *before.curl_m().rbegin());
    }

  for (const double casting : {0.7, 0.85, 1.0, 1.15, 1.3})
    EXPECT_THAT(whole_forecast(ensemble(21), misread(casting, 1.0)).warnings(),
                ::testing::IsEmpty())
        << casting;
}

/// Whether a forecast warns of the scale or sign of a gauge.
bool tells_wrong_gauge(const v1::Forecast& forecast) {
  return std::ranges::any_of(forecast.warnings(), [](const v1::ForecastWarning& warning) {
    return warning.causes(0).find("scale or sign") != std::string::npos;
  });
}

TEST(CurlForecast, TakesACastingWhoseCurlFallsBackForNoGaugeThatShowsATenth) {
  auto fallen = readings(1.0, 100.0);
  for (v1::Reading& reading : fallen) {
    const double left = std::clamp(1.0 - (reading.time_s() - 40.0) / 20.0, 0.1, 1.0);
    reading.mutable_curls(0)->set_curl_m(left * shape(reading.time_s()));
  }
  EXPECT_FALSE(tells_wrong_gauge(whole_forecast(ensemble(21), fallen)));
}

TEST(CurlForecast, WarnsWhereMostReadingsAreLeftOut) {
  auto made = readings(1.0, 100.0);
  for (std::size_t i = 12; i < made.size(); ++i)
    if (i % 4 != 0)
      made[i].mutable_curls(0)->set_curl_m((i % 2 == 0 ? 0.4 : -0.3) + 1e-3 * double(i));
  const auto found = whole_forecast(ensemble(21), made);
  const auto texts = std::count_if(
      found.warnings().begin(), found.warnings().end(), [](const v1::ForecastWarning& warning) {
        return warning.text().find("most readings of this gauge are left out") != std::string::npos;
      });
  EXPECT_EQ(texts, 1);
}

/// The readings before the slip have told the curl; those after it tell the new zero.
TEST(CurlForecast, GoesOnWithTheNewZeroOfASlippedGauge) {
  constexpr int castings = 60;
  int of_curl = 0, of_zero = 0;
  for (unsigned seed = 0; seed < castings; ++seed) {
    const auto slipped = forecast(ensemble(21), faulty(4e-3, 0.0, seed));
    EXPECT_NEAR(slipped.zero_m(), 4e-3, 2e-3) << seed;
    EXPECT_EQ(slipped.readings() + slipped.left_out(), 101);
    EXPECT_LE(slipped.left_out(), 2) << seed;
    const double end = 1.1 * shape(end_s);
    of_curl += *slipped.lower_m().rbegin() < end && end < *slipped.upper_m().rbegin();
    of_zero += slipped.zero_lower_m() < 4e-3 && 4e-3 < slipped.zero_upper_m();
  }
  std::printf("bands hold %d and %d of %d\n", of_curl, of_zero, castings);
  EXPECT_GE(of_curl, 0.8 * castings);
  EXPECT_GE(of_zero, 0.8 * castings);
}

void add_finding(v1::StudyRun& run, const char* rule, double time_s,
                 v1::Finding::Severity severity) {
  v1::Finding& finding = *run.add_findings();
  finding.set_code(rule);
  finding.set_time_s(time_s);
  finding.set_severity(severity);
}

TEST(CurlForecast, CountsMembersWithFindingsToCome) {
  v1::StudyResult runs = ensemble(20);
  for (int i = 0; i < 4; ++i)
    add_finding(*runs.mutable_runs(i), "bleed_out_at_exit", 70.0, v1::Finding::DANGER);
  for (int i = 0; i < 9; ++i)
    add_finding(*runs.mutable_runs(i), "hot_tears", i < 2 ? 30.0 : 80.0, v1::Finding::WARNING);
  add_finding(*runs.mutable_runs(0), "hot_tears", 90.0, v1::Finding::WARNING);  // once more
  add_finding(*runs.mutable_runs(5), "remark", 90.0, v1::Finding::NOTE);
  runs.mutable_runs(3)->set_beyond_validity(true);

  const auto found = whole_forecast(runs, readings(1.0, 50.0));
  ASSERT_EQ(found.findings_size(), 2);
  EXPECT_EQ(found.findings(0).rule(), "hot_tears");
  EXPECT_EQ(found.findings(0).members(), 6)
      << "seven that begin later, one of which does not count";
  EXPECT_EQ(found.findings(0).of(), 19);
  EXPECT_EQ(found.findings(1).rule(), "bleed_out_at_exit");
  EXPECT_EQ(found.findings(1).members(), 3);
  EXPECT_THAT(found.notes(), ::testing::ElementsAre(::testing::StartsWith("1 of 20 runs")));
  EXPECT_EQ(whole_forecast(runs, readings(1.0, 75.0)).findings_size(), 1);
}

std::vector<v1::Reading> moved(double speed, double water) {
  auto made = readings(1.0, 100.0);
  for (v1::Reading& reading : made) {
    const bool late = reading.time_s() > 50.0;
    reading.set_casting_speed_m_per_s((late ? speed : 1.0) * 1e-3);
    reading.set_water_flow_m2_per_s((late ? water : 1.0) * 2e-3);
  }
  return made;
}

TEST(CurlForecast, NotesLeversThatLeaveThePlan) {
  EXPECT_THAT(whole_forecast(ensemble(20), moved(1.05, 0.95)).notes(), ::testing::IsEmpty());
  // 50 of 60 seconds: 25 % on average.
  EXPECT_THAT(whole_forecast(ensemble(20), moved(1.3, 0.7)).notes(),
              ::testing::ElementsAre(::testing::StartsWith("the casting speed was 25 % more than"),
                                     ::testing::StartsWith("the water was 25 % less than")));
}

TEST(CurlForecast, CountsWhatExecutedLeversHaveDoneBeforeACurlIsMeasured) {
  std::vector<v1::Reading> levers_alone(1);
  levers_alone.back().set_time_s(80.0);
  const auto curl = ask_off_plan(80.0, levers_alone, forecast_curls).curls(0);
  EXPECT_NEAR(curl.curl_m(0), shape(80.0) + 4e-3, 1e-12);
  EXPECT_NEAR(*curl.curl_m().rbegin(), shape(end_s) + 4e-3, 1e-12);
}

TEST(CurlForecast, TakesWhatExecutedLeversHaveDoneFromEachReading) {
  const auto whole = ask_off_plan(80.0, off_plan(80.0), forecast_curls);
  const auto& curl = whole.curls(0);
  EXPECT_NEAR(*curl.curl_m().rbegin(), 1.1 * shape(end_s) + 4e-3, 0.5e-3);
  EXPECT_NEAR(curl.curl_m(0), 1.1 * shape(80.0) + 4e-3, 0.5e-3);
  EXPECT_EQ(*curl.measured_m().rbegin(), 1.1 * shape(80.0) + 4e-3) << "as the gauge shows it";
  EXPECT_THAT(whole.warnings(), ::testing::IsEmpty());

  // What is learned is that of the casting as planned.
  const auto as_planned = forecast(ensemble(21), readings(1.1, 80.0));
  EXPECT_NEAR(*curl.curl_m().rbegin() - *as_planned.curl_m().rbegin(), 4e-3, 1e-12);
}

TEST(CurlForecast, IsWiderTheLongerAgoTheLeversAreKnown) {
  const auto curl = ask_off_plan(60.0, off_plan(60.0), forecast_curls).curls(0);
  const auto as_planned = forecast(ensemble(21), readings(1.1, 60.0));
  const auto half = [](const v1::ForecastCurl& of, int i) { return of.upper_m(i) - of.curl_m(i); };
  const int last = curl.time_s_size() - 1;
  EXPECT_NEAR(half(curl, 0), half(as_planned, 0), 1e-12);
  EXPECT_EQ(curl.time_s(last) - curl.time_s(0), 60.0);
  EXPECT_NEAR(half(curl, last),
              std::hypot(half(as_planned, last), 1.645 * 0.5 * done_by_levers(60.0)), 1e-9);
}

TEST(CurlForecast, IsWiderByTheShareThatLeversAreOffThePlan) {
  auto measured = readings(1.1, 60.0);
  const auto as_planned = forecast(ensemble(21), measured), prior = forecast(ensemble(21), {});
  for (v1::Reading& reading : measured) {
    reading.set_casting_speed_m_per_s(0.8e-3);
    reading.set_water_flow_m2_per_s(2.2e-3);
  }
  const auto off = forecast(ensemble(21), measured);
  EXPECT_EQ(*off.curl_m().rbegin(), *as_planned.curl_m().rbegin());
  EXPECT_NEAR(width_at_end(off), std::hypot(width_at_end(as_planned), 0.3 * width_at_end(prior)),
              1e-9);
  EXPECT_EQ(off.upper_m(0), as_planned.upper_m(0)) << "what it is now is measured";
}

/// A forecast from a run of the plan alone, whose curl is the shape.
/// @param error  of the plan, that of a section unless given
v1::Forecast unprepared(const std::vector<v1::Reading>& measured, double error = 0.5) {
  v1::Following with = following();
  with.clear_ensemble();
  with.set_plan_job("job-1");
  const v1::Case complete = plan();
  const v1::StudyResult none;
  const v1::StudyResult run = ensemble(3);  // the second one has the factor 1
  return forecast_curls({.ensemble = none,
                         .pairs = none,
                         .plan = complete,
                         .following = with,
                         .readings = measured,
                         .plan_run = {run.runs(1).curves().begin(), run.runs(1).curves().end()},
                         .error_of_plan = error});
}

TEST(UnpreparedForecast, IsThePlanPlusTheLastDifference) {
  const auto before = unprepared({}).curls(0);
  EXPECT_EQ(before.members(), 0);
  EXPECT_NEAR(*before.curl_m().rbegin(), shape(end_s), 1e-12);
  EXPECT_EQ(before.before().curl_m(), *before.curl_m().rbegin());

  const auto whole = unprepared(readings(1.2, 50.0));
  const auto& curl = whole.curls(0);
  EXPECT_EQ(curl.time_s(0), 50.0);
  for (int i = 0; i < curl.time_s_size(); ++i) {
    EXPECT_NEAR(curl.curl_m(i), shape(curl.time_s(i)) + 0.2 * shape(50.0), 0.3e-3);
    EXPECT_LT(curl.lower_m(i), 1.2 * shape(curl.time_s(i)));
    EXPECT_GT(curl.upper_m(i), 1.2 * shape(curl.time_s(i)));
    if (i == 0) continue;
    EXPECT_GE(curl.upper_m(i) - curl.lower_m(i), curl.upper_m(i - 1) - curl.lower_m(i - 1));
  }
  EXPECT_LT(width_at_end(curl), width_at_end(before));
  EXPECT_THAT(whole.notes(),
              ::testing::ElementsAre(::testing::AllOf(::testing::HasSubstr("was not prepared"),
                                                      ::testing::HasSubstr("job job-1"),
                                                      ::testing::HasSubstr("--prepare"))));
  EXPECT_THAT(whole.findings(), ::testing::IsEmpty());
  EXPECT_EQ(curl.left_out(), 0);
}

constexpr double of_quarter_slab = 0.25, of_section = 0.5;

TEST(UnpreparedForecast, TellsAGaugeOfWrongScaleOrSign) {
  for (const double error : {of_quarter_slab, of_section})
    for (const auto& [scale, mistake] : {std::pair{-1.0, "its sign is turned"},
                                         {10.0, "ten times too large"},
                                         {-10.0, "ten times too large, its sign turned"},
                                         {25.4, "what is read as inches is in mm"},
                                         {1000.0, "what is read as m is in mm"}})
      for (const double casting : {0.85, 1.0, 1.15}) {
        const auto found = unprepared(misread(casting, scale), error);
        ASSERT_EQ(found.warnings_size(), 1) << scale << " of " << casting << ", " << error;
        EXPECT_THAT(found.warnings(0).causes(0), ::testing::HasSubstr(mistake));
        EXPECT_LT(found.warnings(0).time_s(), 60.0) << scale << " of " << casting << ", " << error;
        EXPECT_EQ(found.curls(0).readings(), 0);
      }
}

TEST(UnpreparedForecast, TakesACastingThatCurlsOtherwiseForNoWrongGauge) {
  for (const double casting : {0.2, 0.5, 1.0, 1.5, 2.3})
    EXPECT_FALSE(tells_wrong_gauge(unprepared(misread(casting, 1.0)))) << casting;

  auto early = readings(1.0, 100.0);
  for (v1::Reading& reading : early)
    reading.mutable_curls(0)->set_curl_m(2.0 * shape(reading.time_s() + 30.0));
  EXPECT_FALSE(tells_wrong_gauge(unprepared(early)));
}

TEST(UnpreparedForecast, TakesASlipAndAWrongZeroForNoWrongScale) {
  for (const double off_m : {-0.1, -0.05, 0.05, 0.1, 0.3})
    for (const double from_s : {-20.0, 20.0, 60.0}) {
      auto measured = readings(1.0, 100.0);
      for (v1::Reading& reading : measured) {
        v1::MeasuredCurl& curl = *reading.mutable_curls(0);
        if (reading.time_s() >= from_s) curl.set_curl_m(curl.curl_m() + off_m);
      }
      EXPECT_FALSE(tells_wrong_gauge(unprepared(measured))) << off_m << " from " << from_s;
    }
}

TEST(UnpreparedForecast, TellsNothingOfAGaugeWhereItsNoiseHidesTheCurl) {
  for (const double scale : {-1.0, 0.1, 10.0}) {
    auto measured = misread(0.03, scale);  // 0.9 mm in all
    EXPECT_FALSE(tells_wrong_gauge(unprepared(measured))) << scale;
  }
}

}  // namespace
}  // namespace dccast::studies
