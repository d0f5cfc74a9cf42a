#include "core/thermal/cooling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/thermal/heat_solver.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

Water start_up_water(double temperature = 25.0) {
  Water water = testing::water();
  water.temperature = Curve(temperature);
  water.boiling_follows_flow = true;
  water.wetting = testing::wetting();
  return water;
}

Film film(double flow, double temperature = 25.0) {
  return {temperature, flow};
}

TEST(Boiling, KeepsTheStatedValuesAtTheirFlows) {
  const Water water = start_up_water();
  EXPECT_DOUBLE_EQ(critical_heat_flux(water, film(full_flow), 0.0), 4e6);
  EXPECT_DOUBLE_EQ(critical_heat_flux(water, film(full_flow), 0.03), 0.6 * 4e6);
  EXPECT_DOUBLE_EQ(rewetting_temperature(water.wetting, film(start_flow)), 500.0);
  EXPECT_DOUBLE_EQ(film_coefficient(water.wetting, film(start_flow), 0.0), 2000.0);
  EXPECT_DOUBLE_EQ(film_coefficient(water.wetting, film(start_flow), 0.03), 400.0);
}

/// Gas stays in the water on its way down the face.
TEST(Boiling, GasLowersTheCriticalHeatFluxOfTheWholeFilm) {
  const Water water = start_up_water();
  const std::vector<WetPiece> pieces(3,
                                     {.area = 1e-3, .at = {0.0, 0.1}, .surface_temperature = 200});
  std::vector<WaterPlace> plain, gassed;
  march_film(water, {25.0, full_flow}, 1.0, 1.0, pieces, plain);
  march_film(water, {25.0, full_flow, 0.25}, 1.0, 1.0, pieces, gassed);
  ASSERT_EQ(gassed.size(), plain.size());
  EXPECT_DOUBLE_EQ(gassed[0].critical_heat_flux, 0.25 * plain[0].critical_heat_flux);
  EXPECT_EQ(gassed[2].film.critical_factor, 0.25);
}

/// The exponents, checked by doubling the flow.
TEST(Boiling, FollowsTheFlow) {
  const Water water = start_up_water();
  const Film half = film(0.5e-3), whole = film(1e-3);
  EXPECT_NEAR(critical_heat_flux(water, whole, 0.0) / critical_heat_flux(water, half, 0.0),
              std::cbrt(2.0), 1e-14);
  EXPECT_NEAR((rewetting_temperature(water.wetting, whole) - 250.0) /
                  (rewetting_temperature(water.wetting, half) - 250.0),
              std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(
      film_coefficient(water.wetting, whole, 0.0) / film_coefficient(water.wetting, half, 0.0),
      std::sqrt(2.0), 1e-14);
  EXPECT_EQ(rewetting_temperature(water.wetting, film(0.1)), 600.0) << "the limit";
}

/// Warmer water has a lower critical flux and rewetting temperature and cools less through vapour.
TEST(Boiling, FollowsTheFilmTemperature) {
  const Water water = start_up_water();
  Film before = film(1e-3, 5.0);
  for (const double temperature : {25.0, 45.0, 65.0, 85.0, 100.0}) {
    const Film here = film(1e-3, temperature);
    EXPECT_LT(critical_heat_flux(water, here, 0.0), critical_heat_flux(water, before, 0.0));
    EXPECT_LT(rewetting_temperature(water.wetting, here),
              rewetting_temperature(water.wetting, before));
    EXPECT_LT(film_coefficient(water.wetting, here, 0.0),
              film_coefficient(water.wetting, before, 0.0));
    before = here;
  }
  // Saturated water still bears a third: 1 / (1 + 2.7 sqrt(1603) (4217 75 / 2.257e6)^2).
  EXPECT_NEAR(critical_heat_flux(water, film(full_flow, 100.0), 0.0) / 4e6, 1.0 / 3.123, 1e-3);
}

/// Fluxes of a surface that has become as wet as it ever will, as docs/water.md prints them; peaks
/// of 1 to 5 MW/m2 at 100 to 300 l/min/m are published.
TEST(Boiling, MeetsTheEquilibriumFluxes) {
  const Water water = start_up_water();
  const auto flux = [&](double litres_per_minute, double surface, double depth) {
    const Film here = film(litres_per_minute / 60e3);
    const double rewetting = rewetting_temperature(water.wetting, here);
    const WaterPlace place{.film = here,
                           .wetted = wet_in_the_end(water.wetting, surface, rewetting),
                           .rewetting = rewetting,
                           .critical_heat_flux = critical_heat_flux(water, here, depth),
                           .film_coefficient = film_coefficient(water.wetting, here, depth)};
    return water_flux(water, place, {surface, 0.0}, {}).flux / 1e6;
  };
  EXPECT_NEAR(flux(90, 150, 0.0), 3.2, 0.05);
  EXPECT_NEAR(flux(90, 600, 0.0), 1.4, 0.05);
  EXPECT_NEAR(flux(180, 300, 0.0), 4.0, 0.05);
  EXPECT_NEAR(flux(300, 400, 0.0), 4.7, 0.05);
  EXPECT_NEAR(flux(45, 500, 0.03), 0.39, 0.01);
  EXPECT_NEAR(flux(180, 300, 0.03), 2.4, 0.05);
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
  const Outcome little = run(start_up_water(), 0.5e-3, 4.0),
                much = run(start_up_water(), 3e-3, 4.0);
  EXPECT_LT(little.worst_balance, 1e-10);
  EXPECT_LT(much.worst_balance, 1e-10);
  EXPECT_GT(much.side, 3.0 * little.side);
  const auto wet = [](const Outcome& o) {
    return std::ranges::count_if(o.field.wetted, [](double share) { return share > 0.5; });
  };
  EXPECT_EQ(wet(little), 0);
  EXPECT_GT(wet(much), 3);
}

/// Down to flows that evaporate to the last drop. Any step length: the bound holds by construction.
TEST_F(StartUp, NoFaceGivesOffMoreThanItsWaterTakes) {
  CoolingSpec cooling = testing::casting_cooling();
  for (const double flow : {3e-3, 3e-4, 6e-5, 1.7e-5, 2e-6}) {
    for (const double step : {0.05, 1.0, 10.0}) {
      cooling.water = start_up_water();
      cooling.water.wetting.least_flow = 0.0;
      cooling.water.wetting.throw_off_length = 10.0;
      HeatSolver solver(material::ThermalProperties(testing::casting_alloy()), cooling,
                        make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
      HeatField field = solver.uniform_field(400.0);
      field.wetted.assign(faces * field.enthalpy.size(), 1.0);
      for (int k = 1; k <= 5; ++k) {
        HeatStepInput input;
        input.time = k * step;
        input.time_step = step;
        input.metal_level = 0.1;
        input.casting_temperature = 680.0;
        input.water_flow = flow;
        const HeatStepOutcome outcome = solver.step(field, input);
        ASSERT_TRUE(outcome.converged) << flow << ' ' << step;
        const double capacity =
            flow * water_density * (water_specific_heat * 75.0 + evaporation_heat);
        EXPECT_NEAR(outcome.water[0].capacity, capacity, 1e-9 * capacity);
        EXPECT_LE(outcome.water[0].taken, capacity * (1.0 + 1e-12)) << flow << ' ' << step;
        EXPECT_LT(outcome.balance.error, 1e-10);
      }
    }
  }
}

TEST_F(StartUp, PulsedWaterTakesLessHeat) {
  Water pulsed = start_up_water();
  pulsed.pulse_period = 1.0;
  pulsed.pulse_share = 0.5;
  pulsed.pulse_end = 100.0;
  const double steady = run(start_up_water(), 3e-3, 4.0).side,
               in_pulses = run(pulsed, 3e-3, 4.0).side;
  EXPECT_LT(in_pulses, 0.9 * steady);
  EXPECT_GT(in_pulses, 0.4 * steady);
}

/// The field contains everything a step needs from the previous one: a resumed run gives the same
/// bits.
TEST_F(StartUp, WettingIsPartOfTheState) {
  CoolingSpec cooling = testing::casting_cooling();
  cooling.water = start_up_water();
  const auto solver = [&] {
    return HeatSolver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
  };
  HeatSolver used = solver(), fresh = solver();
  HeatField field = used.uniform_field(470.0);
  field.wetted.assign(faces * field.enthalpy.size(), 1.0);
  HeatField dry = field, resumed = field;
  dry.wetted.clear();
  HeatStepInput input;
  input.time = input.time_step = 0.25;
  input.metal_level = 0.1;
  input.casting_temperature = 680.0;
  input.water_flow = start_flow;
  const double wet_side = used.step(field, input).balance.side;

  EXPECT_GT(wet_side, 2.0 * used.step(dry, input).balance.side);
  EXPECT_GT(fresh.step(resumed, input).balance.side, 0.0);
  EXPECT_EQ(field.enthalpy, resumed.enthalpy);
  EXPECT_EQ(field.wetted, resumed.wetted);
}

/// The zones and the water hang on the mould; the uppermost zone ends where the metal does.
TEST(SideLaws, OnlyTheUppermostZoneFollowsTheMetal) {
  CoolingSpec cooling = testing::casting_cooling();
  const SideLaws level(cooling, {.mould_level = 0.1, .water_runs = {true, true}});
  const SideLaws higher(cooling, {.mould_level = 0.1, .water_runs = {true, true}, .above = 0.02});
  EXPECT_EQ(level.at(-0.01, Face::wide).number, law_dry);
  EXPECT_EQ(higher.at(-0.01, Face::wide).number, 0);
  for (const double distance : {0.0, 0.029, 0.031, 0.064, 0.066})
    EXPECT_EQ(higher.at(distance, Face::wide).number, level.at(distance, Face::wide).number);

  cooling.zones[0].from = 5e-3;
  EXPECT_EQ(SideLaws(cooling, {.above = 0.02}).at(-0.01, Face::wide).number, law_dry);
}

/// Its temperature may be given for a step, as a casting measures it. At 150 degC the face is below
/// the boiling crisis, whose heat flux does not know the water.
TEST_F(StartUp, WaterOfAStepIsAsWarmAsItIsSaid) {
  const auto side_at = [&](std::optional<double> given, double of_table) {
    CoolingSpec cooling = testing::casting_cooling();
    cooling.water.temperature = Curve(of_table);
    HeatSolver solver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
    HeatField field = solver.uniform_field(150.0);
    HeatStepInput input{.time = 0.25, .time_step = 0.25, .metal_level = 0.1, .water_flow = 2e-3};
    input.water_temperature[0] = given;
    return solver.step(field, input).balance.side;
  };
  EXPECT_EQ(side_at(40.0, 25.0), side_at({}, 40.0));
  EXPECT_LT(side_at(40.0, 25.0), side_at({}, 25.0));
}

/// A second row of jets 15 mm below the first, on hot metal.
class SecondJets : public StartUp {
protected:
  struct Step {
    double side = 0.0;
    FaceWater water{};
    HeatField field;
  };

  Step step(double first, double second, double hot = 400.0, double dt = 0.25, Water water = {}) {
    CoolingSpec cooling = testing::casting_cooling();
    cooling.water = water.enabled ? water : start_up_water();
    cooling.second_water = {.from = 0.08};
    HeatSolver solver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab_.mesh(), mesh::SectionKind::plane_strain));
    Step made{.field = solver.uniform_field(hot)};
    for (int k = 1; k <= 4; ++k) {
      const HeatStepInput input{.time = k * dt,
                                .time_step = dt,
                                .metal_level = 0.1,
                                .casting_temperature = 680.0,
                                .water_flow = first,
                                .second_water_flow = second};
      const HeatStepOutcome outcome = solver.step(made.field, input);
      EXPECT_TRUE(outcome.converged);
      EXPECT_LT(outcome.balance.error, 1e-10);
      EXPECT_LE(outcome.water[0].taken, outcome.water[0].capacity * (1.0 + 1e-12));
      made.water = outcome.water[0];
      made.side += outcome.balance.side;
    }
    return made;
  }

  static double capacity(double flow) {
    return flow * water_density * (water_specific_heat * 75.0 + evaporation_heat);
  }
  /// Wetted share of the side at a height [m].
  double wetted_at(const Step& made, double height) const {
    double nearest = 1.0, wetted = 0.0;
    for (int n = 0; n < slab_.mesh().nodes(); ++n) {
      const double* at = slab_.mesh().point(n);
      const double off = std::abs(at[1] - height);
      if (at[0] < 0.28 - 1e-9 || off >= nearest) continue;
      nearest = off;
      wetted = made.field.wetted[faces * std::size_t(n)];
    }
    return wetted;
  }
};

TEST(Films, ThatJoinAddFlowHeatAndGas) {
  const Film film = joined({20.0, 1e-3, 0.2}, {80.0, 3e-3, 1.0});
  EXPECT_DOUBLE_EQ(film.flow, 4e-3);
  EXPECT_DOUBLE_EQ(film.temperature, 65.0);
  EXPECT_DOUBLE_EQ(film.critical_factor, 0.8);
}

TEST_F(SecondJets, OfNoFlowAreNoJets) {
  CoolingSpec cooling = testing::casting_cooling();
  const Outcome alone = run(start_up_water(), 1e-3, 1.0, 400.0);
  EXPECT_EQ(step(1e-3, 0.0).field.enthalpy, alone.field.enthalpy);
}

/// The face is as wet as its own water makes it above them, and wetter below.
TEST_F(SecondJets, CoolBelowTheirLineAlone) {
  const Step first = step(0.5e-3, 0.0, 560.0), both = step(0.5e-3, 2e-3, 560.0),
             second = step(0.0, 2e-3, 560.0);
  EXPECT_GT(both.side, 1.05 * first.side);
  // Metal 10 mm above the second line is a little colder by conduction.
  EXPECT_NEAR(wetted_at(both, 0.03), wetted_at(first, 0.03), 2e-3) << "above the second line";
  EXPECT_GT(wetted_at(both, 0.005), wetted_at(first, 0.005) + 0.1);
  EXPECT_EQ(wetted_at(second, 0.03), 0.0) << "dry above";
  EXPECT_NEAR(both.water.capacity, capacity(2.5e-3), 1e-9 * capacity(2.5e-3));
}

/// Down to the last drop: what the water takes is checked in every step.
TEST_F(SecondJets, TakeNoMoreThanTheirFlowCanCarry) {
  for (const double first : {0.0, 2e-6, 3e-4, 3e-3})
    for (const double second : {2e-6, 6e-5, 3e-3})
      for (const double dt : {0.05, 1.0, 10.0}) {
        Water thirsty = start_up_water();
        thirsty.wetting.least_flow = 0.0;
        thirsty.wetting.throw_off_length = 10.0;
        const Step made = step(first, second, 450.0, dt, thirsty);
        EXPECT_NEAR(made.water.capacity, capacity(first + second), 1e-9 * capacity(first + second));
      }
}

/// Water that steam has thrown off does not come back, and the second jets wet the face alone.
TEST_F(SecondJets, WetAFaceThatHasThrownItsWaterOff) {
  Water thrown = start_up_water();
  thrown.wetting.throw_off_length = 0.0;
  thrown.wetting.jet_length = 5e-3;
  const Step first = step(0.3e-3, 0.0, 600.0, 0.25, thrown),
             both = step(0.3e-3, 3e-3, 600.0, 0.25, thrown);
  EXPECT_TRUE(first.water.thrown_off);
  EXPECT_EQ(wetted_at(first, 0.005), 0.0);
  EXPECT_GT(wetted_at(both, 0.015), 0.02);
}

}  // namespace
}  // namespace dccast::thermal
