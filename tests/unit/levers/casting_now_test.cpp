#include "server/levers/casting_progress.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace dccast::levers {
namespace {

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
  plan.mutable_time()->set_end_s(1e4);
  return plan;
}

v1::Reading speed_reading(double time_s, double speed) {
  v1::Reading reading;
  reading.set_time_s(time_s);
  reading.set_casting_speed_m_per_s(speed);
  return reading;
}

v1::CastingNow casting_now(const v1::Case& plan, const std::vector<v1::Reading>& readings) {
  CastingProgress casting(plan);
  for (const v1::Reading& reading : readings) casting.follow(reading);
  return casting.now();
}

TEST(CastingNow, HasThePlanAtTheMeasuredCastLength) {
  // 10 s at 0.1 m/s, after half of the first second: 1 m is cast at 10.5 s, and the plan is 2e-3
  // m/s.
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

}  // namespace
}  // namespace dccast::levers
