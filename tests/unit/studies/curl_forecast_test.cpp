#include "server/studies/curl_forecast.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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

v1::ForecastCurl forecast(const v1::StudyResult& runs, const std::vector<v1::Reading>& measured,
                          const v1::RelativeError& mesh_error = {}) {
  const v1::Following with = following();
  return forecast_curls({runs, mesh_error, with, measured}).curls(0);
}

double width_at_end(const v1::ForecastCurl& curl) {
  return *curl.upper_m().rbegin() - *curl.lower_m().rbegin();
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
  v1::RelativeError mesh_error;
  mesh_error.set_lower(0.04);
  mesh_error.set_upper(0.10);
  const auto plain = forecast(ensemble(21), {}), moved = forecast(ensemble(21), {}, mesh_error);
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

}  // namespace
}  // namespace dccast::studies
