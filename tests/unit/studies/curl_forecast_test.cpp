#include "server/studies/curl_forecast.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "server/studies/levers_off_plan.hpp"
#include "server/studies/planned_levers.hpp"

namespace dccast::studies {
namespace {

constexpr double end_s = 120.0;

double shape(double time_s) {
  return time_s <= 0.0 ? 0.0 : 0.03 * (1.0 - std::exp(-time_s / 40.0));
}

/// Runs whose curls are a shape times 0.8 to 1.2.
v1::StudyResult ensemble(int members) {
  v1::StudyResult result;
  for (int i = 0; i < members; ++i) {
    v1::StudyRun& run = *result.add_runs();
    run.set_state(v1::SUCCEEDED);
    run.add_values(fmt::format("{} W/m/K", 100 + i));
    v1::CurlCurve& curve = *run.add_curves();
    curve.set_monitor("corner");
    for (double t = -30.0; t <= end_s; t += 2.0) {
      curve.add_time_s(t);
      curve.add_curl_m(t < 0.0 ? NAN : (0.8 + 0.4 * i / (members - 1)) * shape(t));
    }
  }
  return result;
}

v1::Following following(double zero_m = 0.0) {
  v1::Following with;
  with.set_ensemble("study");
  v1::Gauge& gauge = *with.add_gauges();
  gauge.set_monitor("corner");
  gauge.set_noise_m(0.5e-3);
  gauge.set_zero_m(zero_m);
  return with;
}

/// Readings of every second of a casting whose curl is the shape times a factor.
std::vector<v1::Reading> readings(double factor, double until_s) {
  std::vector<v1::Reading> made;
  for (double t = -10.0; t <= until_s; t += 1.0) {
    v1::Reading& reading = made.emplace_back();
    reading.set_time_s(t);
    v1::MeasuredCurl& curl = *reading.add_curls();
    curl.set_monitor("corner");
    curl.set_curl_m(factor * shape(t));
  }
  return made;
}

v1::Schedule plan() {
  v1::Schedule schedule;
  schedule.mutable_casting_speed_m_per_s()->add_value(1e-3);
  schedule.mutable_water_flow_m2_per_s()->add_value(2e-3);
  return schedule;
}

/// Runs whose curls are off by the mesh, -4 +10 %.
v1::StudyResult with_band(v1::StudyResult runs) {
  for (v1::StudyRun& run : *runs.mutable_runs()) {
    run.mutable_mesh_error()->set_lower(0.04);
    run.mutable_mesh_error()->set_upper(0.10);
  }
  return runs;
}

v1::Forecast whole_forecast(const v1::StudyResult& runs, const std::vector<v1::Reading>& measured,
                            const v1::StudyResult& pairs = {}) {
  const v1::Following with = following();
  const v1::Schedule schedule = plan();
  return forecast_curls({.ensemble = runs,
                         .pairs = pairs,
                         .plan = schedule,
                         .following = with,
                         .readings = measured});
}

v1::ForecastCurl forecast(const v1::StudyResult& runs, const std::vector<v1::Reading>& measured,
                          const v1::StudyResult& pairs = {}) {
  return whole_forecast(runs, measured, pairs).curls(0);
}

double width_at_end(const v1::ForecastCurl& curl) {
  return *curl.upper_m().rbegin() - *curl.lower_m().rbegin();
}

/// A plan whose speed rises with cast length, whose water comes at 5 s.
v1::Case plan_by_length() {
  v1::Case plan;
  v1::Curve& speed = *plan.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::CAST_LENGTH);
  for (const double place : {0.0, 1.0}) {
    speed.add_at(place);
    speed.add_value(1e-3 + 1e-3 * place);
  }
  plan.mutable_schedule()->mutable_water_flow_m2_per_s()->add_value(2e-3);
  plan.mutable_schedule()->mutable_casting_temperature_c()->add_value(690.0);
  plan.mutable_cooling()->mutable_water()->set_enabled(true);
  plan.mutable_cooling()->mutable_water()->set_start_s(5.0);
  return plan;
}

v1::Reading speed_reading(double time_s, double speed) {
  v1::Reading reading;
  reading.set_time_s(time_s);
  reading.set_casting_speed_m_per_s(speed);
  return reading;
}

TEST(CastingNow, HasThePlanAtTheMeasuredCastLength) {
  // 10 s at 0.1 m/s, after half of the first second: 1 m is cast at 10.5 s, and the plan is 2e-3 m/s.
  std::vector<v1::Reading> readings{speed_reading(-20.0, 0.0), speed_reading(0.0, 0.0)};
  for (double t = 1.0; t <= 10.5; t += 0.5) readings.push_back(speed_reading(t, 0.1));

  const v1::CastingNow now = casting_now(plan_by_length(), readings);
  EXPECT_NEAR(now.planned().casting_speed_m_per_s(), 2e-3, 1e-12);
  EXPECT_EQ(now.planned().water_flow_m2_per_s(), 2e-3);
  EXPECT_EQ(now.planned().casting_temperature_c(), 690.0);
  EXPECT_FALSE(now.planned().has_narrow_water_flow_m2_per_s());
}

TEST(CastingNow, PlansNeitherSpeedNorWaterInTheHold) {
  const v1::CastingNow now = casting_now(plan_by_length(), {speed_reading(-3.0, 0.0)});
  EXPECT_EQ(now.planned().casting_speed_m_per_s(), 0.0);
  EXPECT_EQ(now.planned().water_flow_m2_per_s(), 0.0);
}

TEST(CastingNow, KeepsAValueForTenSeconds) {
  std::vector<v1::Reading> readings{speed_reading(0.0, 1e-3), speed_reading(1.0, 2e-3)};
  v1::MeasuredCurl& curl = *readings.back().add_curls();
  curl.set_monitor("corner");
  curl.set_curl_m(5e-3);
  readings.emplace_back().set_time_s(11.0);
  v1::Reading measured = casting_now(plan_by_length(), readings).measured();
  EXPECT_EQ(measured.time_s(), 11.0);
  EXPECT_EQ(measured.casting_speed_m_per_s(), 2e-3);
  ASSERT_EQ(measured.curls_size(), 1);

  readings.emplace_back().set_time_s(11.5);
  measured = casting_now(plan_by_length(), readings).measured();
  EXPECT_FALSE(measured.has_casting_speed_m_per_s());
  EXPECT_TRUE(measured.curls().empty());
}

TEST(CastingNow, HasTheLastCurlOfEachGauge) {
  std::vector<v1::Reading> readings(2);
  for (int i : {0, 1}) {
    readings[i].set_time_s(i);
    v1::MeasuredCurl& curl = *readings[i].add_curls();
    curl.set_monitor("corner");
    curl.set_curl_m(1e-3 * i);
  }
  const v1::Reading measured = casting_now(plan_by_length(), readings).measured();
  ASSERT_EQ(measured.curls_size(), 1);
  EXPECT_EQ(measured.curls(0).curl_m(), 1e-3);
}

TEST(CastingNow, SaysWhetherMoreComes) {
  EXPECT_FALSE(casting_now(plan_by_length(), {}).has_measured());
  std::vector<v1::Reading> readings{speed_reading(0.0, 1e-3)};
  EXPECT_FALSE(casting_now(plan_by_length(), readings).closed());
  readings.emplace_back().set_closes(true);
  const v1::CastingNow now = casting_now(plan_by_length(), readings);
  EXPECT_TRUE(now.closed());
  EXPECT_EQ(now.measured().time_s(), 0.0);
}

std::vector<judging::PastForecast> past(const std::vector<v1::Reading>& measured) {
  const v1::StudyResult runs = ensemble(21), pairs;
  const v1::Following with = following();
  const v1::Schedule schedule = plan();
  return past_forecasts({.ensemble = runs,
                         .pairs = pairs,
                         .plan = schedule,
                         .following = with,
                         .readings = measured});
}

TEST(PastForecasts, KnowTheReadingsBeforeAlone) {
  const auto far = past(readings(1.15, 110.0)).back();
  EXPECT_EQ(far.ahead_s, 60.0);
  ASSERT_EQ(far.time_s.size(), 51u) << "from 60 to 110 s";
  EXPECT_EQ(far.time_s.front(), 60.0);

  // What was forecast at 40 s for 100 s.
  const auto then = forecast(ensemble(21), readings(1.15, 40.0));
  const auto at =
      static_cast<int>(std::ranges::find(then.time_s(), 100.0) - then.time_s().begin());
  const auto i = static_cast<std::size_t>(std::ranges::find(far.time_s, 100.0) - far.time_s.begin());
  EXPECT_NEAR(far.expected_m[i], then.curl_m(at), 1e-12);
  EXPECT_EQ(far.measured_m[i], 1.15 * shape(100.0));

  // A reading has the noise of the gauge besides.
  const double half = far.upper_m[i] - far.expected_m[i];
  const double of_curl = then.upper_m(at) - then.curl_m(at);
  EXPECT_NEAR(half * half, of_curl * of_curl + std::pow(1.645 * 0.5e-3, 2), 1e-3 * half * half);
}

TEST(PastForecasts, LeaveOutliersOut) {
  auto measured = readings(1.0, 110.0);
  measured[100].mutable_curls(0)->set_curl_m(0.2);  // at 90 s
  for (const auto& each : past(measured))
    EXPECT_EQ(std::ranges::count(each.time_s, 90.0), 0) << each.ahead_s;
  EXPECT_EQ(past(measured).back().time_s.size(), 50u);
}

TEST(PastForecasts, DoNotReachAcrossASlipOfTheGauge) {
  auto measured = readings(1.0, 110.0);
  for (v1::Reading& reading : measured)
    if (reading.time_s() >= 50.0)
      reading.mutable_curls(0)->set_curl_m(reading.curls(0).curl_m() + 10e-3);

  const auto made = past(measured);
  for (const double time_s : made.front().time_s)
    EXPECT_TRUE(time_s < 50.0 || time_s - 30.0 >= 50.0) << time_s;
  EXPECT_GT(made.front().time_s.back(), 100.0);
  for (std::size_t i = 0; i < made.front().time_s.size(); ++i)
    EXPECT_NEAR(made.front().measured_m[i], made.front().expected_m[i], 2e-3);
}

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

/// Readings whose gauge is off from a time on, with a noise of half a millimetre.
std::vector<v1::Reading> faulty(double slip_m, double drift_m_per_s, unsigned seed = 3) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.5e-3);
  auto made = readings(1.1, 100.0);
  for (v1::Reading& reading : made) {
    const double after = reading.time_s() - 60.0;
    const double off = after < 0.0 ? 0.0 : slip_m + drift_m_per_s * after;
    v1::MeasuredCurl& curl = *reading.mutable_curls(0);
    curl.set_curl_m(curl.curl_m() + off + noise(random));
  }
  return made;
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

void add_finding(v1::StudyRun& run, const char* rule, double time_s, v1::Finding::Severity severity) {
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
  EXPECT_EQ(found.findings(0).members(), 6) << "seven that begin later, one of which does not count";
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

/// What levers that leave the plan at 30 s have done by a time: up to 4 mm at 70 s.
double done_by_levers(double time_s) {
  return 4e-3 * std::clamp((time_s - 30.0) / 40.0, 0.0, 1.0);
}

v1::CurlCurve run_until(double until_s, bool has_plan_levers) {
  v1::CurlCurve curve;
  curve.set_monitor("corner");
  for (double t = 0.0; t <= until_s; t += 2.0) {
    curve.add_time_s(t);
    curve.add_curl_m(shape(t) + (has_plan_levers ? 0.0 : done_by_levers(t)));
  }
  return curve;
}

/// A casting whose curl is the shape times 1.1 and what the levers have done.
std::vector<v1::Reading> off_plan(double until_s) {
  auto made = readings(1.1, until_s);
  for (v1::Reading& reading : made) {
    v1::MeasuredCurl& curl = *reading.mutable_curls(0);
    curl.set_curl_m(curl.curl_m() + done_by_levers(reading.time_s()));
  }
  return made;
}

/// Asks a forecast of a casting off the plan, with the run that follows it up to a time.
template <typename Ask>
auto ask_off_plan(double until_s, const std::vector<v1::Reading>& measured, Ask ask) {
  const v1::StudyResult runs = ensemble(21), pairs;
  const v1::Following with = following();
  const v1::Schedule schedule = plan();
  return ask(ForecastBasis{.ensemble = runs,
                           .pairs = pairs,
                           .plan = schedule,
                           .following = with,
                           .readings = measured,
                           .plan_run = {run_until(end_s, true)},
                           .followed_run = {run_until(until_s, false)}});
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

TEST(PastForecasts, KnowTheLeversBeforeAlone) {
  const auto far = ask_off_plan(110.0, off_plan(110.0), past_forecasts).back();
  const auto error_at = [&](double time_s) {
    const auto i = std::ranges::find(far.time_s, time_s) - far.time_s.begin();
    return far.expected_m.at(i) - far.measured_m.at(i);
  };
  EXPECT_NEAR(error_at(90.0), -4e-3, 0.5e-3) << "made at 30 s, before the levers are moved";
  EXPECT_NEAR(error_at(110.0), -2e-3, 0.5e-3) << "made at 50 s";
}

TEST(ObservedCurls, AreThoseOfTheCastingWithItsLeversAsPlanned) {
  const v1::ObservedCurl curl = ask_off_plan(110.0, off_plan(110.0), observed_curls).at(0);
  for (int i = 0; i < curl.time_s_size(); ++i)
    EXPECT_NEAR(curl.curl_m(i), 1.1 * shape(curl.time_s(i)), 1e-4) << "a median of some seconds";
}

TEST(LeversOffPlan, ReadsTablesAgainstTimeAndCastLength) {
  v1::Schedule schedule = plan();
  v1::Curve& speed = *schedule.mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::TIME);
  speed.Clear();
  for (const auto& [at, value] : {std::pair{0.0, 1e-3}, {100.0, 2e-3}}) {
    speed.add_at(at);
    speed.add_value(value);
  }
  speed.set_abscissa(v1::TIME);
  v1::Curve& water = *schedule.mutable_water_flow_factor();
  water.set_abscissa(v1::CAST_LENGTH);
  for (const auto& [at, value] : {std::pair{0.0, 1.0}, {0.15, 2.5}}) {
    water.add_at(at);
    water.add_value(value);
  }

  // The speed rises as planned, and with it the length to 150 mm.
  std::vector<v1::Reading> made = readings(1.0, 100.0);
  for (v1::Reading& reading : made) {
    const double t = std::max(reading.time_s(), 0.0);
    reading.set_casting_speed_m_per_s(1e-3 + 1e-5 * t);
    reading.set_water_flow_m2_per_s(2e-3 * (1.0 + 10.0 * (1e-3 * t + 0.5e-5 * t * t)));
  }
  EXPECT_THAT(levers_off_plan(schedule, made), ::testing::IsEmpty());
  for (v1::Reading& reading : made) reading.set_water_flow_m2_per_s(2e-3);
  EXPECT_EQ(levers_off_plan(schedule, made).size(), 1u);
}

/// A forecast from a run of the plan alone, whose curl is the shape.
v1::Forecast unprepared(const std::vector<v1::Reading>& measured) {
  v1::Following with = following();
  with.clear_ensemble();
  with.set_plan_job("job-1");
  const v1::Schedule schedule = plan();
  const v1::StudyResult none;
  const v1::StudyResult run = ensemble(3);  // the second one has the factor 1
  return forecast_curls({.ensemble = none,
                         .pairs = none,
                         .plan = schedule,
                         .following = with,
                         .readings = measured,
                         .plan_run = {run.runs(1).curves().begin(), run.runs(1).curves().end()}});
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
  EXPECT_THAT(whole.notes(), ::testing::ElementsAre(::testing::AllOf(
                                 ::testing::HasSubstr("was not prepared"),
                                 ::testing::HasSubstr("job job-1"), ::testing::HasSubstr("--prepare"))));
  EXPECT_THAT(whole.findings(), ::testing::IsEmpty());
  EXPECT_EQ(curl.left_out(), 0);
}

/// The ensemble on another recipe: its castings curl half as much.
v1::StudyResult other_recipe() {
  v1::StudyResult runs = ensemble(21);
  for (v1::StudyRun& run : *runs.mutable_runs())
    for (double& curl : *run.mutable_curves(0)->mutable_curl_m()) curl *= 0.5;
  return runs;
}

/// A casting that has ended: all its readings, on a recipe.
EarlierCasting earlier(const v1::StudyResult& recipe, const std::vector<v1::Reading>& measured,
                       const std::string& job = "job-1") {
  const v1::Following with = following(1e-3);
  const v1::Schedule schedule = plan();
  EarlierCasting casting{.casting = {},
                         .ensemble = std::make_shared<v1::StudyResult>(recipe),
                         .pairs = std::make_shared<v1::StudyResult>()};
  const auto curls = observed_curls({.ensemble = recipe,
                                     .pairs = *casting.pairs,
                                     .plan = schedule,
                                     .following = with,
                                     .readings = measured});
  casting.casting.set_job(job);
  casting.casting.set_ended(true);
  *casting.casting.mutable_following() = with;
  *casting.casting.mutable_curls() = {curls.begin(), curls.end()};
  return casting;
}

v1::Forecast on_line(const v1::StudyResult& runs, const std::vector<EarlierCasting>& castings) {
  v1::Following with = following(1e-3);
  with.set_line("pit-3");
  const v1::Schedule schedule = plan();
  const v1::StudyResult none;
  return forecast_curls({.ensemble = runs,
                         .pairs = none,
                         .plan = schedule,
                         .following = with,
                         .readings = {},
                         .earlier = castings});
}

TEST(LineForecast, CastingsOnALineTellTheNextOneBeforeItBegins) {
  const v1::StudyResult runs = ensemble(21);
  const auto alone = on_line(runs, {});
  EXPECT_EQ(alone.curls(0).line().castings(), 0);
  EXPECT_EQ(*alone.curls(0).curl_m().rbegin(), *forecast(runs, {}).curl_m().rbegin());

  double width = width_at_end(alone.curls(0));
  for (const int count : {1, 4}) {
    const std::vector<EarlierCasting> castings(count, earlier(runs, readings(1.15, end_s)));
    const auto curl = on_line(runs, castings).curls(0);
    EXPECT_EQ(curl.line().castings(), count);
    EXPECT_EQ(curl.members(), 21);
    EXPECT_LT(width_at_end(curl), 0.9 * width);
    EXPECT_NEAR(*curl.curl_m().rbegin(), 1.15 * shape(end_s), 0.25 * width);
    width = width_at_end(curl);
  }
}

TEST(LineForecast, ACastingOnOneRecipeInformsAnother) {
  const v1::StudyResult runs = other_recipe();
  const std::vector<EarlierCasting> castings(4, earlier(ensemble(21), readings(1.15, end_s)));
  const auto curl = on_line(runs, castings).curls(0);
  EXPECT_EQ(curl.line().castings(), 4);
  EXPECT_NEAR(curl.before().curl_m(), 0.5 * 1.15 * shape(end_s), 0.02 * shape(end_s));
  EXPECT_LT(width_at_end(curl), 0.5 * width_at_end(on_line(runs, {}).curls(0)));
}

/// Castings that differ much tell less than those that are alike, and show a larger scatter.
TEST(LineForecast, TellsTheScatterFromCastingToCasting) {
  const v1::StudyResult runs = ensemble(21);
  std::vector<EarlierCasting> alike, scattered;
  for (int i = 0; i < 6; ++i) {
    alike.push_back(earlier(runs, readings(1.1 + 0.005 * (i % 3), end_s)));
    scattered.push_back(earlier(runs, readings(0.9 + 0.2 * (i % 2), end_s)));
  }
  const auto same = on_line(runs, alike).curls(0), other = on_line(runs, scattered).curls(0);
  EXPECT_LT(same.line().scatter(), 0.2);
  EXPECT_GT(other.line().scatter(), 0.4);
  EXPECT_LT(width_at_end(same), 0.7 * width_at_end(other));
}

TEST(LineForecast, LeavesOutCastingsWithOtherDataAndWithoutTheirStudy) {
  const v1::StudyResult runs = ensemble(21);
  v1::StudyResult of_other_data = runs;
  for (v1::StudyRun& run : *of_other_data.mutable_runs()) run.set_values(0, run.values(0) + "/2");

  auto lost = earlier(runs, readings(1.15, end_s), "job-2");
  lost.ensemble.reset();
  const auto whole = on_line(runs, {earlier(of_other_data, readings(1.15, end_s)), lost});
  EXPECT_EQ(whole.curls(0).line().castings(), 0);
  EXPECT_THAT(whole.notes(),
              ::testing::ElementsAre(::testing::HasSubstr("job job-2 on the line does not count: its study"),
                                     ::testing::HasSubstr("job job-1 on the line does not count: its "
                                                          "ensemble has other data")));

  // The other key, with the same values, is other data too.
  v1::StudyResult of_other_key = runs;
  of_other_key.mutable_study()->mutable_sweep()->add_axes()->set_key("schedule.hold");
  EXPECT_EQ(on_line(runs, {earlier(of_other_key, readings(1.15, end_s))}).notes_size(), 1);
}

TEST(ObservedCurls, AreMediansOfReadingsThatCountUntilAGaugeSlips) {
  auto measured = readings(1.1, end_s);
  for (v1::Reading& reading : measured)
    if (reading.time_s() == 59.0) reading.mutable_curls(0)->set_curl_m(0.5);
  const auto curls = earlier(ensemble(21), measured).casting.curls();
  ASSERT_EQ(curls.size(), 1);
  ASSERT_EQ(curls[0].time_s_size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(curls[0].time_s(i), 10.0 * (i + 1), 1e-9);
    EXPECT_NEAR(curls[0].curl_m(i), 1.1 * shape(10.0 * (i + 1)), 0.3e-3);
    const double readings_near = i == 5 ? 4.0 : i == 11 ? 3.0 : 5.0;
    EXPECT_NEAR(curls[0].deviation_m(i), 1.25 * 0.5e-3 / std::sqrt(readings_near), 1e-9);
  }

  const auto slipped = earlier(ensemble(21), faulty(4e-3, 0.0)).casting.curls();
  ASSERT_GE(slipped[0].time_s_size(), 4);
  EXPECT_LE(*slipped[0].time_s().rbegin(), 61.0);
}

}  // namespace
}  // namespace dccast::studies
