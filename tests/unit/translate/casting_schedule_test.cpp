// The two homes of the schedule, that of the core and that of the clients, on random cases.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/casting/case/casting_schedule.hpp"
#include "core/thermal/cooling.hpp"
#include "proto/case_file/schedule.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {
namespace {

using case_file::Face, case_file::Instant;

/// Draws cases whose tables are against time or cast length.
class RandomCases {
public:
  v1::Case draw() {
    v1::Case c;
    c.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
    c.mutable_time()->set_end_s(between(50.0, 300.0));

    v1::Schedule& schedule = *c.mutable_schedule();
    schedule.set_hold_s(between(0.0, 90.0));
    schedule.set_filling_s(chance() ? between(0.0, schedule.hold_s()) : 0.0);
    draw_table(0.2e-3, 1.2e-3, *schedule.mutable_casting_speed_m_per_s());
    draw_table(650.0, 720.0, *schedule.mutable_casting_temperature_c());
    draw_table(1e-3, 4e-3, *schedule.mutable_water_flow_m2_per_s());
    if (chance()) draw_table(1e-3, 4e-3, *schedule.mutable_narrow_water_flow_m2_per_s());
    if (chance()) draw_table(0.5, 1.5, *schedule.mutable_casting_speed_factor());
    if (chance()) draw_table(0.5, 1.5, *schedule.mutable_water_flow_factor());
    if (chance()) schedule.set_casting_speed_shift_s(between(-30.0, 30.0));
    if (chance()) schedule.set_water_flow_shift_s(between(-30.0, 30.0));
    if (chance()) {
      draw_table(0.0, 2e-3, *schedule.mutable_second_water_flow_m2_per_s());
      c.mutable_cooling()->mutable_second_water()->set_start_s(between(-20.0, 60.0));
    }
    if (chance()) draw_table(-0.02, 0.02, *schedule.mutable_metal_level_m());

    draw_water(*c.mutable_cooling()->mutable_water());
    if (chance()) draw_water(*c.mutable_cooling()->mutable_narrow_water());
    return c;
  }

  double between(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }

private:
  bool chance() { return between(0.0, 1.0) < 0.5; }

  void draw_table(double low, double high, v1::Curve& curve) {
    const bool by_length = chance();
    const int points = std::uniform_int_distribution(1, 5)(random_);
    curve.set_abscissa(by_length ? v1::CAST_LENGTH : v1::TIME);
    double at = by_length ? between(0.0, 0.1) : between(-20.0, 60.0);
    for (int i = 0; i < points; ++i) {
      curve.add_at(at);
      curve.add_value(between(low, high));
      at += by_length ? between(5e-3, 0.1) : between(5.0, 80.0);
    }
  }

  void draw_water(v1::Water& water) {
    water.set_enabled(between(0.0, 1.0) < 0.9);
    water.set_start_s(between(-20.0, 60.0));
    draw_table(10.0, 40.0, *water.mutable_temperature_c());
    draw_table(0.1, 1.0, *water.mutable_critical_heat_flux_factor());
    if (chance()) return;
    water.set_pulse_period_s(between(1.0, 20.0));
    water.set_pulse_share(between(0.0, 1.0));
    water.set_pulse_end_s(between(-10.0, 200.0));
  }

  std::mt19937 random_{56};
};

void expect_same(double here, double core, const char* name) {
  EXPECT_LE(std::abs(here - core), 1e-12 * std::abs(core)) << name << ": " << here << ", " << core;
}

void compare_values(const case_file::CastingSchedule& here, const casting::Case& c,
                    const Instant& at) {
  const casting::CastingSchedule core(c);
  const auto [time, length] = at;
  expect_same(here.casting_speed().at(at), core.planned_speed(time, length), "speed");
  expect_same(here.casting_temperature().at(at), core.casting_temperature(time, length), "metal");
  expect_same(here.flow_m2_per_s(Face::wide, at), core.water_flow(time, length), "water");
  expect_same(here.flow_m2_per_s(Face::narrow, at), core.narrow_water_flow(time, length), "narrow");
  expect_same(here.filled_share(time), core.filled_share(time), "level");
  expect_same(here.second_flow_m2_per_s(at), core.second_water_flow(time, length), "second");
  if (time > 0.0) expect_same(here.metal_level().at(at), core.metal_level(time, length), "height");
  for (const auto& [face, of_core] : {std::pair(Face::wide, thermal::Face::wide),
                                      std::pair(Face::narrow, thermal::Face::narrow)}) {
    EXPECT_EQ(here.valve_is_open(face, time), thermal::is_open(c.cooling.water_of(of_core), time));
    expect_same(here.water_temperature(face).at(at), core.water_temperature(of_core, time, length),
                "water temperature");
    expect_same(here.critical_heat_flux_factor(face).at(at),
                core.critical_heat_flux_factor(of_core, time, length), "critical heat flux");
  }
}

/// Compares the cast lengths at some times, where the core makes many steps if the speed depends on
/// the length: a step of a run meets the bends of such a table in its middle.
void compare_lengths(const case_file::CastingSchedule& here, const casting::Case& c,
                     const std::vector<double>& times) {
  constexpr double step_s = 0.05;
  const casting::CastingSchedule core(c);
  const double bound_m = core.speed_follows_time() ? 1e-9 : 1e-6;

  double length = 0.0, time = here.begin_s();
  for (const double to : times) {
    const auto pieces = std::int64_t(std::ceil((to - time) / step_s));
    length = core.cast_length_over(length, time, to, pieces);
    time = to;
    EXPECT_NEAR(here.cast_length_m(to), length, bound_m) << to << " s";
    if (length > 0.0 && to < here.end_s()) {
      EXPECT_NEAR(here.cast_length_m(here.time_of_cast_length_s(length)), length, 1e-9);
    }
  }
}

TEST(CastingSchedule, IsTheSameHereAndInTheCore) {
  RandomCases cases;
  for (int number = 0; number < 1000 && !HasFailure(); ++number) {
    SCOPED_TRACE(number);
    const v1::Case drawn = cases.draw();
    const casting::Case c = to_core(drawn, "");
    const case_file::CastingSchedule here(drawn);
    EXPECT_EQ(here.begin_s(), casting::CastingSchedule(c).begin());
    EXPECT_EQ(here.end_s(), casting::CastingSchedule(c).end_of_casting());

    std::vector<double> times;
    for (int i = 0; i < 5; ++i) times.push_back(cases.between(here.begin_s(), here.end_s() + 20.0));
    std::sort(times.begin(), times.end());
    for (const double time : times) compare_values(here, c, {time, cases.between(0.0, 0.4)});
    compare_lengths(here, c, times);
  }
}

}  // namespace
}  // namespace dccast::translate
