#include "proto/case_file/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace dccast::case_file {
namespace {

TEST(CurveValue, IsLinearBetweenThePointsAndConstantOutside) {
  v1::Curve curve;
  for (const double at : {1.0, 2.0, 4.0}) {
    curve.add_at(at);
    curve.add_value(10.0 * at);
  }
  EXPECT_EQ(curve_value(curve, 0.0), 10.0);
  EXPECT_EQ(curve_value(curve, 1.0), 10.0);
  EXPECT_DOUBLE_EQ(curve_value(curve, 2.5), 25.0);
  EXPECT_EQ(curve_value(curve, 9.0), 40.0);
}

TEST(CurveValue, WithoutPlacesIsConstant) {
  v1::Curve curve;
  curve.add_value(3.0);
  EXPECT_EQ(curve_value(curve, -7.0), 3.0);
}

/// 40 to 60 mm/min and water from 1 to 2 mm2/s, both from 60 to 200 s.
v1::Case ramps() {
  v1::Case c;
  v1::Schedule& schedule = *c.mutable_schedule();
  for (auto* const curve :
       {schedule.mutable_casting_speed_m_per_s(), schedule.mutable_water_flow_m2_per_s()}) {
    curve->set_abscissa(v1::TIME);
    curve->add_at(60.0);
    curve->add_at(200.0);
  }
  schedule.mutable_casting_speed_m_per_s()->add_value(40.0 / 60e3);
  schedule.mutable_casting_speed_m_per_s()->add_value(60.0 / 60e3);
  schedule.mutable_water_flow_m2_per_s()->add_value(1e-3);
  schedule.mutable_water_flow_m2_per_s()->add_value(2e-3);
  schedule.set_hold_s(60.0);
  schedule.set_filling_s(30.0);
  c.mutable_cooling()->mutable_water()->set_enabled(true);
  c.mutable_time()->set_end_s(250.0);
  return c;
}

/// A factor that jumps to another one at a cast length.
void set_factor_until(double length_m, double before, double after, v1::Curve& factor) {
  factor.set_abscissa(v1::CAST_LENGTH);
  for (const double at : {length_m, length_m + 1e-6}) factor.add_at(at);
  for (const double value : {before, after}) factor.add_value(value);
}

TEST(CastingSchedule, LengthIsTheIntegralOfTheSpeedUntilTheEnd) {
  const v1::Case c = ramps();
  const CastingSchedule schedule(c);
  EXPECT_EQ(schedule.cast_length_m(-10.0), 0.0);
  EXPECT_NEAR(schedule.cast_length_m(130.0), 1e-3 * (40.0 + 70.0 * 45.0 / 60.0), 1e-15);
  EXPECT_NEAR(schedule.cast_length_at_end_m(), 1e-3 * (40.0 + 140.0 * 50.0 / 60.0 + 50.0), 1e-15);
  EXPECT_EQ(schedule.cast_length_m(300.0), schedule.cast_length_at_end_m());
  EXPECT_NEAR(schedule.time_of_cast_length_s(schedule.cast_length_m(130.0)), 130.0, 1e-9);
  EXPECT_NEAR(schedule.time_of_cast_length_s(0.060 + schedule.cast_length_at_end_m()), 310.0, 1e-9)
      << "as if the casting went on";
}

TEST(CastingSchedule, AFactorMayEndAtACastLength) {
  v1::Case c = ramps();
  set_factor_until(0.02, 0.5, 1.0, *c.mutable_schedule()->mutable_casting_speed_factor());
  // 20 mm/min for the first 20 mm, whose end is met exactly.
  const CastingSchedule schedule(c);
  EXPECT_NEAR(schedule.time_of_cast_length_s(0.02), 60.0, 1e-9);
  EXPECT_NEAR(schedule.cast_length_m(60.0), 0.02, 1e-12);
  EXPECT_NEAR(schedule.cast_length_m(200.0), 0.02 + 140.0 * 50.0 / 60e3, 1e-6);
}

TEST(CastingSchedule, InstantsShowEveryBendAndJump) {
  v1::Case c = ramps();
  v1::Water& water = *c.mutable_cooling()->mutable_water();
  water.set_start_s(10.0);
  water.set_pulse_period_s(4.0);
  water.set_pulse_share(0.5);
  water.set_pulse_end_s(19.0);
  c.mutable_schedule()->set_water_flow_shift_s(5.0);
  const CastingSchedule schedule(c);

  std::vector<double> times;
  for (const Instant& instant : schedule.instants()) {
    times.push_back(instant.time_s);
    if (instant.time_s <= schedule.end_s()) {
      EXPECT_NEAR(instant.cast_length_m, schedule.cast_length_m(instant.time_s), 1e-15);
    }
  }
  EXPECT_TRUE(std::ranges::is_sorted(times));
  EXPECT_EQ(times.front(), -60.0);
  for (const double bend : {0.0, 10.0, 12.0, 14.0, 16.0, 18.0, 19.0, 60.0, 65.0, 205.0, 250.0})
    EXPECT_TRUE(std::ranges::count(times, bend)) << bend;
}

}  // namespace
}  // namespace dccast::case_file
