#include "server/levers/levers_off_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/support/shaped_castings.hpp"

namespace dccast::studies {
namespace {

using levers::levers_off_plan;

TEST(LeversOffPlan, ReadsTablesAgainstTimeAndCastLength) {
  v1::Case complete = plan();
  v1::Schedule& schedule = *complete.mutable_schedule();
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
  EXPECT_THAT(levers_off_plan(complete, made), ::testing::IsEmpty());
  for (v1::Reading& reading : made) reading.set_water_flow_m2_per_s(2e-3);
  EXPECT_EQ(levers_off_plan(complete, made).size(), 1u);
}

TEST(LeversOffPlan, JudgesTheReadingsThatHaveALever) {
  std::vector<v1::Reading> made = readings(1.0, 100.0);
  for (std::size_t i = 0; i < made.size(); i += 10)
    if (made[i].time_s() >= 0.0) made[i].set_casting_speed_m_per_s(0.7e-3);
  EXPECT_THAT(levers_off_plan(plan(), made),
              ::testing::ElementsAre(::testing::HasSubstr("casting speed was 30 % less than")));
}

}  // namespace
}  // namespace dccast::studies
