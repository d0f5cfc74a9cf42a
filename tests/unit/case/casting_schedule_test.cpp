#include "core/casting/case/casting_schedule.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::small_casting;

TEST(CastingSchedule, LengthIsTheExactIntegralOfTheSpeed) {
  Case c = small_casting();
  c.schedule.casting_speed = {Abscissa::time, {5.0, 15.0}, {1e-3, 2e-3}};
  const CastingSchedule schedule(c);
  EXPECT_EQ(schedule.begin(), -10.0);
  EXPECT_EQ(schedule.end(), 20.0);
  EXPECT_EQ(schedule.cast_length(0.0, -10.0, 9.0), 0.0);
  EXPECT_NEAR(schedule.cast_length(0.0, -1.0, 3.0), 2e-3, 1e-17) << "nothing before time zero";

  // The result does not depend on the division of time: 5 s at 1 mm/s, 10 s at a mean of 1.5, 5 s
  // at 2.
  for (double dt : {20.0, 7.0, 1.0, 0.3}) {
    double length = 0.0;
    for (double t = 0.0; t < 20.0 - 1e-12; t += dt) {
      length = schedule.cast_length(length, t, std::min(dt, 20.0 - t));
    }
    EXPECT_NEAR(length, 5e-3 + 15e-3 + 10e-3, 1e-14) << dt;
  }
}

/// V = a + b L gives L = a/b (exp(b t) - 1); the formula of Runge and Kutta is of order 4.
TEST(CastingSchedule, SpeedMayDependOnTheCastLength) {
  Case c = small_casting();
  c.schedule.casting_speed = {Abscissa::cast_length, {0.0, 10.0}, {0.1, 2.1}};
  const CastingSchedule schedule(c);
  const double exact = 0.5 * (std::exp(0.2 * 10.0) - 1.0);
  const auto error = [&](int steps) {
    double length = 0.0;
    for (int i = 0; i < steps; ++i)
      length = schedule.cast_length(length, i * 10.0 / steps, 10.0 / steps);
    return std::abs(length - exact);
  };
  EXPECT_NEAR(std::log2(error(10) / error(20)), 4.0, 0.2);
  EXPECT_LE(error(40), 1e-6);
}

/// V = (a + b L) (1 + c t) gives L = a/b (exp(b (t + c t^2 / 2)) - 1), with the same order.
TEST(CastingSchedule, AFactorAgainstTimeMayChangeASpeedAgainstLength) {
  Case c = small_casting();
  c.schedule.casting_speed = {Abscissa::cast_length, {0.0, 20.0}, {0.1, 4.1}};
  c.schedule.casting_speed_factor = {Abscissa::time, {0.0, 10.0}, {1.0, 2.0}};
  const CastingSchedule schedule(c);
  const double exact = 0.5 * (std::exp(0.2 * (10.0 + 0.05 * 100.0)) - 1.0);
  const auto error = [&](std::int64_t steps) {
    return std::abs(schedule.cast_length_over(0.0, 0.0, 10.0, steps) - exact);
  };
  EXPECT_NEAR(std::log2(error(20) / error(40)), 4.0, 0.2);
}

TEST(CastingSchedule, StepsEndWhereSomethingChanges) {
  Case c = small_casting();
  c.cooling.water.start = 2.6;
  c.mechanics.start = 1.35;
  const CastingSchedule schedule(c);
  std::vector<double> ends;
  double t = schedule.begin(), shortest = 1e9;
  while (t < schedule.end() - 1e-9) {
    const double dt = schedule.step_at(t);
    EXPECT_GT(dt, 0.0);
    EXPECT_LE(dt, 1.0 + 1e-8);
    if (std::abs(t + 0.001) > 1e-9 && std::abs(t - 4.0) > 1e-9) shortest = std::min(shortest, dt);
    t += dt;
    ends.push_back(t);
  }

  for (double event : {-0.001, 0.0, 1.35, 2.6, 4.0, 4.001, 20.0}) {
    EXPECT_TRUE(std::any_of(ends.begin(), ends.end(), [&](double e) {
      return std::abs(e - event) < 1e-8;
    })) << event;
  }
  // A remainder is shared, not left over: but for the two millisecond jumps of the table itself no
  // step is below a third of what is asked for.
  EXPECT_GE(shortest, 0.25 / 3.0);
}

/// A step ends at each event, even if the steps change on the way.
TEST(CastingSchedule, StepsEndWhereFramesAreStored) {
  Case c = small_casting();
  c.output.frame_interval = 0.7;
  c.time.step = {Abscissa::time, {-10.0, 20.0}, {0.31, 1.4}};
  const CastingSchedule schedule(c);
  double next = schedule.next_frame(-10.0);
  EXPECT_NEAR(next, -9.3, 1e-12);

  int frames = 0;
  for (double t = schedule.begin(); t < schedule.end() - 1e-9;) {
    t += schedule.step_at(t);
    ASSERT_LE(t, next + 1e-9);
    if (t < next - 1e-9) continue;
    next = schedule.next_frame(t);
    EXPECT_NEAR(next, -10.0 + 0.7 * (++frames + 1), 1e-9);
  }
  EXPECT_EQ(frames, 42);
}

std::int64_t steps_one_by_one(const CastingSchedule& schedule) {
  std::int64_t steps = 0;
  for (double t = schedule.begin(); t < schedule.end() - 1e-9; ++steps) t += schedule.step_at(t);
  return steps;
}

std::int64_t steps_by_leaps(const CastingSchedule& schedule, std::int64_t& leaps) {
  std::int64_t steps = 0;
  leaps = 0;
  for (double t = schedule.begin(); t < schedule.end() - 1e-9; ++leaps) {
    const Leap leap = schedule.leap(t);
    steps += leap.steps;
    t = leap.to;
  }
  return steps;
}

/// Constant, growing and shrinking steps: counted in closed form as they are made.
TEST(CastingSchedule, LeapsCountTheStepsThatWouldBeMade) {
  Case c = small_casting();
  c.output.frame_interval = 1e6;  // steps end at the frames too
  c.time.end = 400.0;
  for (const Curve& step : {Curve(0.0173), Curve(Abscissa::time, {0.0, 300.0}, {0.01, 0.5}),
                            Curve(Abscissa::time, {-5.0, 350.0}, {0.3, 0.002})}) {
    c.time.step = step;
    const CastingSchedule schedule(c);
    std::int64_t leaps = 0;
    EXPECT_EQ(steps_by_leaps(schedule, leaps), steps_one_by_one(schedule));
    EXPECT_LT(leaps, 600);
  }
}

TEST(CastingSchedule, ABillionStepsAreCountedAtOnce) {
  Case c = small_casting();
  c.output.frame_interval = 1e6;
  c.time.end = 1e6;
  c.time.step = Curve(1e-3);
  std::int64_t leaps = 0;
  EXPECT_NEAR(static_cast<double>(steps_by_leaps(CastingSchedule(c), leaps)), 1.00001e9, 10.0);
  EXPECT_LT(leaps, 50);
}

TEST(CastingSchedule, AFewStepsAreMadeOneByOne) {
  const CastingSchedule schedule(small_casting());
  for (double t = schedule.begin(); t < schedule.end() - 1e-9; t += schedule.step_at(t)) {
    EXPECT_EQ(schedule.leap(t).steps, 1);
    EXPECT_EQ(schedule.leap(t).to, t + schedule.step_at(t));
  }
}

TEST(CastingSchedule, WaterRunsAfterItsStart) {
  Case c = small_casting();
  c.cooling.water.start = 3.0;
  EXPECT_EQ(CastingSchedule(c).water_flow(3.0, 0.0), 0.0) << "the step that ends there is dry";
  EXPECT_EQ(CastingSchedule(c).water_flow(3.1, 0.0), 2e-3);
  c.cooling.water.enabled = false;
  EXPECT_EQ(CastingSchedule(c).water_flow(3.1, 0.0), 0.0);
}

TEST(CastingSchedule, StepsEndWhereTheValveMoves) {
  Case c = small_casting();
  c.time.step = Curve(1.0);
  c.cooling.water.pulse_period = 3.0;
  c.cooling.water.pulse_share = 0.4;
  c.cooling.water.pulse_end = 8.0;
  c.cooling.narrow_water = c.cooling.water;
  c.cooling.narrow_water->start = 0.7;
  const CastingSchedule schedule(c);
  std::vector<double> ends;
  for (double t = schedule.begin(); t < schedule.end() - 1e-9;)
    ends.push_back(t += schedule.step_at(t));
  for (const double event : {1.2, 3.0, 4.2, 6.0, 7.2, 8.0, 0.7, 1.9, 3.7, 4.9, 6.7, 7.9}) {
    EXPECT_TRUE(std::ranges::any_of(ends, [&](double e) { return std::abs(e - event) < 1e-8; }))
        << event;
  }
}

TEST(CastingSchedule, FactorsMultiplyAndShiftsMoveTables) {
  Case c = small_casting();
  c.schedule.water_flow = {Abscissa::time, {0.0, 10.0}, {1e-3, 3e-3}};
  c.schedule.water_flow_factor = {Abscissa::cast_length, {0.0, 0.1}, {0.5, 1.5}};
  c.schedule.water_flow_shift = 4.0;
  const CastingSchedule schedule(c);
  EXPECT_DOUBLE_EQ(schedule.water_flow(9.0, 0.05), 2e-3);
  EXPECT_DOUBLE_EQ(schedule.water_flow(9.0, 0.0), 1e-3);
  EXPECT_DOUBLE_EQ(schedule.narrow_water_flow(9.0, 0.05), 2e-3) << "as on the wide face";
  c.schedule.narrow_water_flow = Curve(4e-3);
  EXPECT_DOUBLE_EQ(CastingSchedule(c).narrow_water_flow(9.0, 0.1), 6e-3) << "all flows";
}

/// Ramp times ramp: a parabola in time, however the time is cut.
TEST(CastingSchedule, LengthIsExactWithAFactorAndAShift) {
  Case c = small_casting();
  c.schedule.casting_speed = {Abscissa::time, {0.0, 10.0}, {1e-3, 2e-3}};
  c.schedule.casting_speed_shift = 2.0;
  c.schedule.casting_speed_factor = {Abscissa::time, {5.0, 9.0}, {1.0, 0.5}};
  const CastingSchedule schedule(c);
  ASSERT_TRUE(schedule.speed_follows_time());

  // 1 mm/s to 2 s, rising by 0.1 mm/s2 to 12 s; the factor falls by 0.125 /s between 5 and 9 s.
  const double to_two = 2e-3, to_five = 3 * 1e-3 + 0.5 * 9 * 1e-4;
  const double to_nine = 4 * 1.3e-3 + 8 * (1e-4 - 0.125 * 1.3e-3) - 64.0 / 3.0 * 0.125e-4;
  const double to_twelve = 0.5 * (3 * 1.7e-3 + 4.5 * 1e-4), to_twenty = 0.5 * 8 * 2e-3;
  for (const double dt : {20.0, 3.0, 0.7}) {
    double length = 0.0;
    for (double t = 0.0; t < 20.0 - 1e-12; t += dt)
      length = schedule.cast_length(length, t, std::min(dt, 20.0 - t));
    EXPECT_NEAR(length, to_two + to_five + to_nine + to_twelve + to_twenty, 1e-15) << dt;
  }
  c.schedule.casting_speed_factor = {Abscissa::cast_length, {0.0, 0.1}, {1.0, 0.5}};
  EXPECT_FALSE(CastingSchedule(c).speed_follows_time());
}

TEST(CastingSchedule, TemperatureFollowsTimeOrLength) {
  Case c = small_casting();
  c.schedule.casting_temperature = {Abscissa::time, {0.0, 10.0}, {700.0, 680.0}};
  EXPECT_DOUBLE_EQ(CastingSchedule(c).casting_temperature(5.0, 0.0), 690.0);
  c.schedule.casting_temperature = {Abscissa::cast_length, {0.0, 0.1}, {700.0, 680.0}};
  EXPECT_DOUBLE_EQ(CastingSchedule(c).casting_temperature(5.0, 0.05), 690.0);
}

TEST(CastingSchedule, MeasuredWaterTemperatureAndLevelReplaceThePlan) {
  Case c = small_casting();
  c.cooling.water.temperature = {Abscissa::cast_length, {0.0, 0.1}, {20.0, 40.0}};
  c.schedule.metal_level = {Abscissa::cast_length, {0.0, 0.1}, {0.0, 0.01}};
  CastingSchedule schedule(c);
  using thermal::Face;
  EXPECT_DOUBLE_EQ(schedule.water_temperature(Face::narrow, 5.0, 0.05), 30.0);
  EXPECT_DOUBLE_EQ(schedule.metal_level(5.0, 0.05), 5e-3);
  EXPECT_EQ(schedule.metal_level(0.0, 0.05), 0.0) << "the block stands";
  EXPECT_TRUE(schedule.changes_after(5.0, 0.05));
  EXPECT_FALSE(schedule.changes_after(5.0, 0.11));

  LeverReading reading{.time = 5.0, .value = {}};
  reading.of(Lever::water_temperature) = 12.0;
  reading.of(Lever::metal_level) = -2e-3;
  schedule.append(reading);
  EXPECT_EQ(schedule.water_temperature(Face::wide, 5.0, 0.05), 12.0);
  EXPECT_EQ(schedule.water_temperature(Face::narrow, 5.0, 0.05), 12.0);
  EXPECT_EQ(schedule.metal_level(5.0, 0.05), -2e-3);
}

TEST(CastingSchedule, GasInTheWaterOfAFaceEndsByThePlan) {
  Case c = small_casting();
  c.cooling.water.critical_heat_flux_factor = {Abscissa::cast_length, {0.02, 0.04}, {0.25, 1.0}};
  c.cooling.narrow_water = c.cooling.water;
  c.cooling.narrow_water->critical_heat_flux_factor = Curve(0.5);
  const CastingSchedule schedule(c);
  EXPECT_DOUBLE_EQ(schedule.critical_heat_flux_factor(thermal::Face::wide, 5.0, 0.03), 0.625);
  EXPECT_DOUBLE_EQ(schedule.critical_heat_flux_factor(thermal::Face::narrow, 5.0, 0.03), 0.5);
  EXPECT_TRUE(schedule.changes_after(5.0, 0.03));
  EXPECT_FALSE(schedule.changes_after(5.0, 0.05));
}

/// What a level may do: fall as fast as the block sinks, rise at once, and do what it likes after
/// the end.
TEST(CastingSchedule, TheLevelMayFallAsFastAsTheBlockSinks) {
  Case c = small_casting();
  c.monitors.resize(2);  // a lower level ends below the third
  for (const Curve& level :
       {Curve{Abscissa::cast_length, {0.0, 0.01}, {0.0, -0.01}},
        Curve{Abscissa::time, {2.0, 12.0}, {0.0, -0.01}},
        Curve{Abscissa::time, {0.0, 1e-3, 20.0, 20.1}, {0.0, 0.02, 0.02, -0.02}}}) {
    c.schedule.metal_level = level;
    const CheckedCase checked = check(c);
    EXPECT_TRUE(checked.faults.empty()) << testing::all(checked.faults);
  }
}

}  // namespace
}  // namespace dccast::casting
