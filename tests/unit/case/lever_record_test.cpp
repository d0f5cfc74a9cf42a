#include "core/casting/case/lever_record.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/casting/case/casting_schedule.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::small_casting;

LeverReading reading(double time, std::optional<double> speed, std::optional<double> water = {}) {
  LeverReading r{.time = time, .value = {}};
  r.of(Lever::casting_speed) = speed;
  r.of(Lever::water_flow) = water;
  return r;
}

LeverRecord record(const std::vector<LeverReading>& readings) {
  LeverRecord r;
  for (const LeverReading& each : readings) r.append(each);
  return r;
}

TEST(LeverRecord, InterpolatesBetweenReadingsAndKnowsNothingElse) {
  const LeverRecord r = record({reading(1.0, 2.0), reading(3.0, 6.0)});
  EXPECT_DOUBLE_EQ(r.at(Lever::casting_speed, 1.5).value(), 3.0);
  EXPECT_DOUBLE_EQ(r.at(Lever::casting_speed, 3.0).value(), 6.0);
  EXPECT_FALSE(r.at(Lever::casting_speed, 0.9));
  EXPECT_FALSE(r.at(Lever::casting_speed, 3.1));
  EXPECT_FALSE(r.at(Lever::water_flow, 2.0)) << "never measured";
  EXPECT_EQ(r.last(), 3.0);
}

TEST(LeverRecord, KeepsTheLastValueForAWhile) {
  LeverRecord r = record({reading(0.0, 2.0, 5.0), reading(4.0, 3.0), reading(9.0, 4.0)});
  EXPECT_DOUBLE_EQ(r.at(Lever::water_flow, 7.0).value(), 5.0);
  r.append(reading(12.0, 4.0));
  EXPECT_FALSE(r.at(Lever::water_flow, 10.0)) << "measured 12 s ago";
  r.append(reading(13.0, 4.0, 7.0));
  EXPECT_FALSE(r.at(Lever::water_flow, 12.5));
  EXPECT_DOUBLE_EQ(r.at(Lever::water_flow, 13.0).value(), 7.0);
}

TEST(LeverRecord, KnowsNothingBetweenReadingsFarApart) {
  const LeverRecord r = record({reading(0.0, 2.0), reading(10.5, 2.0), reading(11.0, 4.0)});
  EXPECT_FALSE(r.at(Lever::casting_speed, 5.0));

  const auto stretches = r.stretches(Lever::casting_speed, -1.0, 12.0);
  ASSERT_EQ(stretches.size(), 3u);
  EXPECT_FALSE(stretches[0].integral);
  EXPECT_EQ(stretches[0].to, 10.5);
  EXPECT_DOUBLE_EQ(stretches[1].integral.value(), 1.5);
  EXPECT_FALSE(stretches[2].integral);
  EXPECT_EQ(stretches[2].from, 11.0);
  EXPECT_EQ(stretches[2].to, 12.0);
}

TEST(LeverRecord, TheIntegralDoesNotDependOnTheDivisionOfTime) {
  const LeverRecord r =
      record({reading(0.0, 1.0), reading(2.0, 3.0), reading(5.0, 0.0), reading(7.0, 4.0)});
  for (const double step : {7.0, 2.5, 1.0, 0.3}) {
    double sum = 0.0;
    for (double t = 0.0; t < 7.0 - 1e-12; t += step)
      for (const auto& stretch : r.stretches(Lever::casting_speed, t, std::min(t + step, 7.0)))
        sum += stretch.integral.value();
    EXPECT_NEAR(sum, 4.0 + 4.5 + 4.0, 1e-12) << step;
  }
}

/// What was known while the casting was followed is what is found when it is repeated.
TEST(LeverRecord, LaterReadingsDoNotChangeWhatWasKnown) {
  const std::vector<LeverReading> readings{reading(0.0, 1.0, 3.0),  reading(1.0, {}, 4.0),
                                           reading(2.0, 2.0),       reading(3.5, 2.5, 5.0),
                                           reading(20.0, 1.0, 1.0), reading(20.5, 1.5)};
  const LeverRecord whole = record(readings);
  LeverRecord followed;
  double known = -1.0;
  for (const LeverReading& each : readings) {
    followed.append(each);
    for (double t = known; t <= each.time; t += 0.125)
      for (const Lever lever : {Lever::casting_speed, Lever::water_flow})
        EXPECT_EQ(followed.at(lever, t), whole.at(lever, t)) << t;
    known = each.time;
  }
}

TEST(LeverRecord, RefusesATimeThatIsNotLater) {
  LeverRecord r = record({reading(1.0, 2.0)});
  EXPECT_THROW(r.append(reading(1.0, 2.0)), std::invalid_argument);
  EXPECT_THROW(r.append(reading(0.5, 2.0)), std::invalid_argument);
}

TEST(CastingSchedule, FollowsWhatWasMeasuredAndThenThePlan) {
  Case c = small_casting();
  c.schedule.casting_speed = Curve(1e-3);
  c.schedule.water_flow = Curve(2e-3);
  c.cooling.water.enabled = true;
  c.cooling.water.start = -20.0;
  CastingSchedule schedule(c);
  const double planned_water = schedule.water_flow(5.0, 0.0);

  schedule.append(reading(-2.0, 0.0));
  schedule.append(reading(-1.0, 2e-3, 1e-3));
  schedule.append(reading(4.0, 2e-3, 3e-3));
  EXPECT_NEAR(schedule.cast_length(0.0, -1.0, 1.0), 2e-3, 1e-16) << "the block started early";
  EXPECT_NEAR(schedule.cast_length(0.0, 2.0, 4.0), 4e-3 + 2e-3, 1e-16) << "then the plan";
  EXPECT_DOUBLE_EQ(schedule.water_flow(1.5, 0.0), 2e-3);
  EXPECT_EQ(schedule.water_flow(5.0, 0.0), planned_water);
  EXPECT_DOUBLE_EQ(schedule.narrow_water_flow(4.0, 0.0), 3e-3) << "one flow for all faces";
  EXPECT_EQ(schedule.casting_temperature(1.0, 0.0), 680.0) << "not measured";
}

}  // namespace
}  // namespace dccast::casting
