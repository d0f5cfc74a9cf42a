#include "server/studies/past_forecasts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/shaped_castings.hpp"

namespace dccast::studies {
namespace {

std::vector<judging::PastForecast> past(const std::vector<v1::Reading>& measured) {
  return ask_of(ensemble(21), measured, past_forecasts);
}

TEST(PastForecasts, KnowTheReadingsBeforeAlone) {
  const auto far = past(readings(1.15, 110.0)).back();
  EXPECT_EQ(far.ahead_s, 60.0);
  ASSERT_EQ(far.time_s.size(), 51u) << "from 60 to 110 s";
  EXPECT_EQ(far.time_s.front(), 60.0);

  // What was forecast at 40 s for 100 s.
  const auto then = forecast(ensemble(21), readings(1.15, 40.0));
  const auto at = static_cast<int>(std::ranges::find(then.time_s(), 100.0) - then.time_s().begin());
  const auto i =
      static_cast<std::size_t>(std::ranges::find(far.time_s, 100.0) - far.time_s.begin());
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

TEST(PastForecasts, KnowTheLeversBeforeAlone) {
  const auto far = ask_off_plan(110.0, off_plan(110.0), past_forecasts).back();
  const auto error_at = [&](double time_s) {
    const auto i = std::ranges::find(far.time_s, time_s) - far.time_s.begin();
    return far.expected_m.at(i) - far.measured_m.at(i);
  };
  EXPECT_NEAR(error_at(90.0), -4e-3, 0.5e-3) << "made at 30 s, before the levers are moved";
  EXPECT_NEAR(error_at(110.0), -2e-3, 0.5e-3) << "made at 50 s";
}

/// What a casting with these readings tells the next one on its line.
std::vector<v1::ObservedCurl> observed(const std::vector<v1::Reading>& measured) {
  return ask_of(ensemble(21), measured, observed_curls, {}, 1e-3);
}

TEST(ObservedCurls, AreThoseOfTheCastingWithItsLeversAsPlanned) {
  const v1::ObservedCurl curl = ask_off_plan(110.0, off_plan(110.0), observed_curls).at(0);
  for (int i = 0; i < curl.time_s_size(); ++i)
    EXPECT_NEAR(curl.curl_m(i), 1.1 * shape(curl.time_s(i)), 1e-4) << "a median of some seconds";
}

TEST(ObservedCurls, AreMediansOfReadingsThatCountUntilAGaugeSlips) {
  auto measured = readings(1.1, end_s);
  for (v1::Reading& reading : measured)
    if (reading.time_s() == 59.0) reading.mutable_curls(0)->set_curl_m(0.5);
  const auto curls = observed(measured);
  ASSERT_EQ(curls.size(), 1u);
  ASSERT_EQ(curls[0].time_s_size(), 12);
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(curls[0].time_s(i), 10.0 * (i + 1), 1e-9);
    EXPECT_NEAR(curls[0].curl_m(i), 1.1 * shape(10.0 * (i + 1)), 0.3e-3);
    const double readings_near = i == 5 ? 4.0 : i == 11 ? 3.0 : 5.0;
    EXPECT_NEAR(curls[0].deviation_m(i), 1.25 * 0.5e-3 / std::sqrt(readings_near), 1e-9);
  }

  const auto slipped = observed(faulty(4e-3, 0.0));
  ASSERT_GE(slipped[0].time_s_size(), 4);
  EXPECT_LE(*slipped[0].time_s().rbegin(), 61.0);
}

}  // namespace
}  // namespace dccast::studies
