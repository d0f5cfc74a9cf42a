#include "core/thermal/boiling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/thermal/heat_solver.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

Water start_up_water(double temperature = 25.0) {
  Water water;
  water.temperature = Curve(temperature);
  water.boiling_follows_flow = true;
  return water;
}

TEST(Boiling, IsWhatTheCaseStatesUnlessItFollowsTheFlow) {
  Water water = start_up_water(60.0);
  water.boiling_follows_flow = false;
  const Boiling boiling = boiling_of(water, 0.5e-3, 0.0);
  EXPECT_EQ(boiling.critical_heat_flux, 4e6);
  EXPECT_EQ(boiling.leidenfrost, 350.0);
  EXPECT_EQ(boiling.film_coefficient, 500.0);
}

TEST(Boiling, KeepsTheStatedValuesAtTheirFlows) {
  const Water water = start_up_water();
  EXPECT_DOUBLE_EQ(boiling_of(water, full_flow, 0.0).critical_heat_flux, 4e6);
  EXPECT_DOUBLE_EQ(boiling_of(water, start_flow, 0.0).leidenfrost, 350.0);
  EXPECT_DOUBLE_EQ(boiling_of(water, start_flow, 0.0).film_coefficient, 500.0);
}

/// The exponents, checked by doubling the flow.
TEST(Boiling, FollowsTheFlow) {
  const Water water = start_up_water();
  const Boiling half = boiling_of(water, 1e-3, 0.0), whole = boiling_of(water, 2e-3, 0.0);
  EXPECT_NEAR(whole.critical_heat_flux / half.critical_heat_flux, std::cbrt(2.0), 1e-14);
  EXPECT_NEAR((whole.leidenfrost - 100.0) / (half.leidenfrost - 100.0), 2.0, 1e-14);
  EXPECT_NEAR(whole.film_coefficient / half.film_coefficient, std::sqrt(2.0), 1e-14);
}

/// Colder water has a higher critical flux and Leidenfrost temperature and cools more through its
/// film.
TEST(Boiling, FollowsTheWaterTemperature) {
  Boiling before = boiling_of(start_up_water(5.0), 2e-3, 0.0);
  for (const double temperature : {25.0, 45.0, 65.0, 85.0, 99.0}) {
    const Boiling boiling = boiling_of(start_up_water(temperature), 2e-3, 0.0);
    EXPECT_LT(boiling.critical_heat_flux, before.critical_heat_flux);
    EXPECT_LT(boiling.leidenfrost, before.leidenfrost);
    EXPECT_LT(boiling.film_coefficient, before.film_coefficient);
    EXPECT_GT(boiling.leidenfrost, 100.0);
    before = boiling;
  }
  // Saturated water still bears a third: 1 / (1 + 2.7 sqrt(1603) (4217 75 / 2.257e6)^2).
  const double saturated = boiling_of(start_up_water(100.0), full_flow, 0.0).critical_heat_flux;
  EXPECT_NEAR(saturated / 4e6, 1.0 / 3.123, 1e-3);
}

TEST(Boiling, AWetSurfaceStaysWetAboveTheLeidenfrostTemperature) {
  const Water water = start_up_water();
  const Boiling boiling = boiling_of(water, start_flow, 0.0);
  EXPECT_EQ(film_share(water, boiling, 380.0, false), 1.0);
  EXPECT_EQ(film_share(water, boiling, 380.0, true), 0.0);
  EXPECT_EQ(film_share(water, boiling, 350.0 + film_hysteresis, true), 0.5);
  EXPECT_EQ(film_share(water, boiling, 340.0, false), 0.0);
  Water plain = water;
  plain.boiling_follows_flow = false;
  plain.film_boiling = true;
  EXPECT_EQ(film_share(plain, boiling, 380.0, true), 1.0) << "no hysteresis without the law";
}

TEST(Valve, PulsesFromTheStartToTheirEnd) {
  Water water = start_up_water();
  water.start = 2.0;
  EXPECT_FALSE(is_open(water, 2.0));
  EXPECT_TRUE(is_open(water, 2.1));
  EXPECT_TRUE(is_open(water, 500.0));
  EXPECT_EQ(valve_changes(water, 60.0), std::vector<double>{2.0});
  water.pulse_period = 4.0;
  water.pulse_share = 0.25;
  water.pulse_end = 13.0;
  for (const double open : {2.5, 6.5, 10.5, 13.5, 15.0}) EXPECT_TRUE(is_open(water, open)) << open;
  for (const double closed : {1.0, 3.5, 5.5, 7.5, 12.5})
    EXPECT_FALSE(is_open(water, closed)) << closed;
  auto changes = valve_changes(water, 60.0);
  std::sort(changes.begin(), changes.end());
  EXPECT_EQ(changes, (std::vector<double>{2, 2, 3, 6, 7, 10, 11, 13}));
  EXPECT_EQ(valve_changes(water, 60.0, 3), std::vector<double>{2.0});
  water.enabled = false;
  EXPECT_FALSE(is_open(water, 2.5));
  EXPECT_TRUE(valve_changes(water, 60.0).empty());
}

/// Hot metal under water of a given flow: steps of the whole section.
class StartUp : public ::testing::Test {
protected:
  struct Outcome {
    HeatField field;
    double side = 0.0;
    double worst_balance = 0.0;
  };

  Outcome run(const Water& water, double flow, double end, double from = 600.0) {
    CoolingSpec cooling = testing::casting_cooling();
    cooling.water = water;
    HeatSolver solver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
    Outcome outcome;
    outcome.field = solver.uniform_field(from);
    for (double time = 0.25; time <= end + 1e-9; time += 0.25) {
      HeatStepInput input;
      input.time = time;
      input.time_step = 0.25;
      input.metal_level = 0.1;
      input.casting_temperature = 680.0;
      input.water_flow = flow;
      const HeatStepOutcome step = solver.step(outcome.field, input);
      EXPECT_TRUE(step.converged);
      outcome.side += step.balance.side;
      outcome.worst_balance = std::max(outcome.worst_balance, step.balance.error);
    }
    return outcome;
  }

  mesh::SlabMesh2D slab_{testing::casting_section(mesh::ElementKind::q1)};
};

TEST_F(StartUp, LittleWaterStaysUnderItsFilmAndMuchWets) {
  const Outcome little = run(start_up_water(), 1e-3, 2.0), much = run(start_up_water(), 3e-3, 2.0);
  EXPECT_LT(little.worst_balance, 1e-10);
  EXPECT_LT(much.worst_balance, 1e-10);
  EXPECT_GT(much.side, 3.0 * little.side);
  const auto wet = [](const Outcome& o) { return std::ranges::count(o.field.wetted, 1); };
  EXPECT_EQ(wet(little), 0);
  EXPECT_GT(wet(much), 3);
}

TEST_F(StartUp, PulsedWaterTakesLessHeat) {
  Water pulsed = start_up_water();
  pulsed.pulse_period = 1.0;
  pulsed.pulse_end = 100.0;
  const double steady = run(start_up_water(), 3e-3, 4.0).side,
               in_pulses = run(pulsed, 3e-3, 4.0).side;
  EXPECT_LT(in_pulses, 0.9 * steady);
  EXPECT_GT(in_pulses, 0.4 * steady);
}

/// The field contains everything a step needs from the previous one: a resumed run gives the same
/// bits.
TEST_F(StartUp, FilmIsPartOfTheState) {
  CoolingSpec cooling = testing::casting_cooling();
  cooling.water = start_up_water();
  const auto solver = [&] {
    return HeatSolver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
  };
  HeatSolver used = solver(), fresh = solver();
  // A wet surface between the Leidenfrost temperature and the end of its hysteresis.
  HeatField field = used.uniform_field(370.0);
  field.wetted.assign(field.enthalpy.size(), 1);
  HeatField dry = field, resumed = field;
  dry.wetted.clear();
  HeatStepInput input;
  input.time = input.time_step = 0.25;
  input.metal_level = 0.1;
  input.casting_temperature = 680.0;
  input.water_flow = start_flow;
  const double wet_side = used.step(field, input).balance.side;
  EXPECT_GT(wet_side, 2.0 * used.step(dry, input).balance.side);
  fresh.step(resumed, input);
  EXPECT_EQ(field.enthalpy, resumed.enthalpy);
  EXPECT_EQ(field.wetted, resumed.wetted);
}

}  // namespace
}  // namespace dccast::thermal
