#include "core/material/thermal_properties.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dccast::material {
namespace {

Curve against_temperature(std::vector<double> at, std::vector<double> value) {
  return {Abscissa::temperature, std::move(at), std::move(value)};
}

/// The paper's alloy with every table bent, so that no term of the cubics is zero.
AlloyCard mushy_card() {
  AlloyCard card;
  card.solidus = 620.0;
  card.liquidus = 649.0;
  card.latent_heat = 395e3;
  card.density = against_temperature({0, 620, 649}, {2700, 2557.4, 2360});
  card.specific_heat = against_temperature({20, 400, 630, 700}, {900, 1050, 1150, 1080});
  card.conductivity = against_temperature({100, 600, 649}, {220, 190, 90});
  card.melt_conductivity_factor = {Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, 3.0}};
  return card;
}

AlloyCard isothermal_card() {
  AlloyCard card;
  card.solidus = card.liquidus = 660.0;
  card.latent_heat = 397e3;
  card.density = against_temperature({0, 660}, {2700, 2560});
  card.specific_heat = against_temperature({20, 660}, {900, 1150});
  card.conductivity = Curve(210.0);
  card.melt_conductivity_factor = {Abscissa::liquid_fraction, {0, 1}, {1.0, 95.0 / 210.0}};
  return card;
}

/// Paper eq. (1) by a fine midpoint rule, kink by kink.
double enthalpy_by_quadrature(const AlloyCard& card, double temperature) {
  const int cells = 400000;
  const double width = temperature / cells;
  double sum = 0.0;
  for (int i = 0; i < cells; ++i) {
    const double at = (i + 0.5) * width;
    double capacity = card.density(at) * card.specific_heat(at);
    if (at > card.solidus && at < card.liquidus) {
      capacity += card.latent_heat * card.density(at) / (card.liquidus - card.solidus);
    }
    sum += capacity * width;
  }
  return sum;
}

/// Heat of a kilogram above 0 °C [J/kg]: linear liquid fraction, midpoint rule.
double heat_per_kilogram(const AlloyCard& card, double temperature) {
  const int cells = 20000;
  const double width = temperature / cells;
  double sum = 0.0;
  for (int i = 0; i < cells; ++i) sum += width * card.specific_heat((i + 0.5) * width);
  return sum + card.latent_heat * liquid_fraction_at(card, temperature);
}

/// The first law for a fixed volume of melt that freezes and cools: it gives off the heat of what
/// it holds and of the melt that flows in at the casting temperature while it shrinks. Feeding ends
/// at the solidus; from there on the metal contracts, and its mass stays.
double heat_of_a_fed_volume(const AlloyCard& card, double from, double to) {
  const double step = 0.01;  // [K]
  const double entering = heat_per_kilogram(card, from);
  double given_off = 0.0;  // [J/m3]
  double before = entering, mass = card.density(from);
  for (double t = from - step; t >= card.solidus - 0.5 * step; t -= step) {
    const double heat = heat_per_kilogram(card, t), fed = card.density(t) - mass;
    given_off += mass * (before - heat) + fed * (entering - heat);
    before = heat;
    mass += fed;
  }
  return given_off + mass * (before - heat_per_kilogram(card, to));
}

TEST(ThermalProperties, AFedVolumeGivesOffTheHeatOfAllItsMetal) {
  AlloyCard card = mushy_card();
  card.density = against_temperature({0, 620, 649}, {2700, 2557.4, 2360});
  const double exact = heat_of_a_fed_volume(card, 680.0, 20.0);

  card.fed_density = density_at_solid_fraction(card, 1.0);
  const ThermalProperties fed(card);
  EXPECT_NEAR(fed.enthalpy(680.0) - fed.enthalpy(20.0), exact, 1e-4 * exact);
  EXPECT_NEAR(fed.solidification_enthalpy() -
                  2557.4 * (heat_per_kilogram(card, 649.0) - heat_per_kilogram(card, 620.0)),
              0.0, 1e-4 * exact);

  // By the density at its temperature a place gives off 3.9 % less latent heat, and cools metal
  // that was never there.
  card.fed_density.reset();
  const ThermalProperties mixture(card);
  const double latent = mixture.solidification_enthalpy() / fed.solidification_enthalpy();
  EXPECT_NEAR(latent, 0.5 * (2360.0 + 2557.4) / 2557.4, 1e-3);
  EXPECT_GT(mixture.enthalpy(600.0) - mixture.enthalpy(20.0),
            1.01 * (fed.enthalpy(600.0) - fed.enthalpy(20.0)));
}

TEST(ThermalProperties, APureMetalIsFedUntilItIsSolid) {
  AlloyCard card = isothermal_card();
  EXPECT_NEAR(density_at_solid_fraction(card, 1.0), card.density(card.solidus), 0.02);
}

TEST(ThermalProperties, EnthalpyIsEquationOne) {
  const AlloyCard card = mushy_card();
  const ThermalProperties metal(card);
  EXPECT_DOUBLE_EQ(metal.enthalpy(0.0), 0.0);
  for (const double temperature : {-50.0, 10.0, 300.0, 500.0, 620.0, 635.0, 649.0, 720.0}) {
    const double expected = enthalpy_by_quadrature(card, temperature);
    // The midpoint rule misplaces the latent heat by up to one of its cells.
    EXPECT_NEAR(metal.enthalpy(temperature), expected, 2e5) << temperature;
  }
}

TEST(ThermalProperties, EnthalpyOfConstantPropertiesIsClosed) {
  AlloyCard card;
  card.solidus = 600.0;
  card.liquidus = 650.0;
  card.latent_heat = 4e5;
  card.density = Curve(2500.0);
  card.specific_heat = Curve(1000.0);
  card.conductivity = Curve(100.0);
  const ThermalProperties metal(card);

  EXPECT_DOUBLE_EQ(metal.enthalpy(500.0), 2500.0 * 1000.0 * 500.0);
  EXPECT_NEAR(metal.enthalpy(625.0), 2500.0 * (1000.0 * 625.0 + 2e5), 1e-5);
  EXPECT_NEAR(metal.enthalpy(700.0), 2500.0 * (1000.0 * 700.0 + 4e5), 1e-5);
  EXPECT_NEAR(metal.kirchhoff(700.0), 70000.0, 1e-9);
  EXPECT_NEAR(metal.solidification_enthalpy(), 2500.0 * (1000.0 * 50.0 + 4e5), 1e-5);
}

TEST(ThermalProperties, InverseReturnsTheTemperature) {
  for (const AlloyCard& card : {mushy_card(), isothermal_card()}) {
    const ThermalProperties metal(card);
    for (double temperature = -100.0; temperature < 900.0; temperature += 0.37) {
      EXPECT_NEAR(metal.temperature(metal.enthalpy(temperature)), temperature, 1e-11);
      EXPECT_NEAR(metal.state(metal.enthalpy(temperature)).kirchhoff, metal.kirchhoff(temperature),
                  1e-8);
    }
  }
}

TEST(ThermalProperties, StateIsContinuousAndMonotone) {
  for (const AlloyCard& card : {mushy_card(), isothermal_card()}) {
    const ThermalProperties metal(card);
    ThermalState last = metal.state(-3e8);
    for (double enthalpy = -3e8; enthalpy < 4e9; enthalpy += 1e6) {
      const ThermalState now = metal.state(enthalpy);
      EXPECT_GE(now.temperature, last.temperature);
      EXPECT_GE(now.kirchhoff, last.kirchhoff);
      EXPECT_GE(now.liquid_fraction, last.liquid_fraction);
      EXPECT_GE(now.kirchhoff_derivative, 0.0);
      EXPECT_LE(now.kirchhoff_derivative, metal.largest_diffusivity());
      EXPECT_LT(now.temperature - last.temperature, 1.0);
      EXPECT_LE(now.liquid_fraction, 1.0);
      last = now;
    }
    EXPECT_EQ(last.liquid_fraction, 1.0);
    EXPECT_EQ(metal.state(0.0).liquid_fraction, 0.0);
  }
}

/// Solid, solid across a kink of the conductivity, mush (each part of the melt factor), liquid.
TEST(ThermalProperties, DerivativesMeetFiniteDifferencesAtSecondOrder) {
  const ThermalProperties metal(mushy_card());
  for (const double temperature : {50.0, 350.0, 610.0, 623.0, 627.0, 633.0, 640.0, 646.0, 670.0}) {
    const double enthalpy = metal.enthalpy(temperature);
    const ThermalState state = metal.state(enthalpy);
    const auto error = [&](double step) {
      const ThermalState up = metal.state(enthalpy + step), down = metal.state(enthalpy - step);
      return std::array{
          std::abs((up.temperature - down.temperature) / (2 * step) - state.temperature_derivative),
          std::abs((up.kirchhoff - down.kirchhoff) / (2 * step) - state.kirchhoff_derivative),
          std::abs((up.liquid_fraction - down.liquid_fraction) / (2 * step) -
                   state.liquid_fraction_derivative)};
    };
    const auto coarse = error(1e6), fine = error(5e5);
    const std::array scale{state.temperature_derivative, state.kirchhoff_derivative,
                           state.liquid_fraction_derivative};
    for (std::size_t i = 0; i < 3; ++i) {
      // Quarter the error, or already at round-off.
      EXPECT_LE(fine[i], 0.3 * coarse[i] + 1e-9 * scale[i]) << temperature << " " << i;
      EXPECT_LE(coarse[i], 1e-3 * scale[i] + 1e-300) << temperature << " " << i;
    }
    EXPECT_NEAR(state.temperature_derivative * metal.enthalpy_derivative(temperature), 1.0, 1e-12);
    EXPECT_NEAR(state.kirchhoff_derivative * metal.enthalpy_derivative(temperature),
                metal.conductivity(temperature), 1e-9);
  }
}

TEST(ThermalProperties, IsothermalChangeIsAJumpOfTheEnthalpy) {
  const AlloyCard card = isothermal_card();
  const ThermalProperties metal(card);
  EXPECT_NEAR(metal.solidification_enthalpy(), 2560.0 * 397e3, 1e-3);

  for (const double fraction : {0.01, 0.5, 0.99}) {
    const double enthalpy = metal.solidus_enthalpy() + fraction * metal.solidification_enthalpy();
    const ThermalState state = metal.state(enthalpy);
    EXPECT_DOUBLE_EQ(state.temperature, 660.0);
    EXPECT_DOUBLE_EQ(state.kirchhoff, metal.kirchhoff(660.0));
    EXPECT_NEAR(state.liquid_fraction, fraction, 1e-12);
    EXPECT_EQ(state.kirchhoff_derivative, 0.0);
    EXPECT_NEAR(state.liquid_fraction_derivative * metal.solidification_enthalpy(), 1.0, 1e-12);
  }
  EXPECT_NEAR(metal.conductivity(659.0), 210.0, 1e-9);
  EXPECT_NEAR(metal.conductivity(661.0), 95.0, 1e-9);
}

TEST(ThermalProperties, MeltFactorStandsAgainstLiquidFraction) {
  const AlloyCard card = mushy_card();
  const ThermalProperties metal(card);
  for (const double temperature : {610.0, 625.0, 634.5, 645.0, 660.0}) {
    const double fraction = std::clamp((temperature - 620.0) / 29.0, 0.0, 1.0);
    EXPECT_NEAR(metal.liquid_fraction(metal.enthalpy(temperature)), fraction, 1e-12);
    EXPECT_NEAR(metal.conductivity(temperature),
                card.conductivity(temperature) * card.melt_conductivity_factor(fraction), 1e-9);
  }
}

TEST(MeltStirring, GainGrowsWithTheCubeOfTheSizeUntilTheMeltIsIsothermal) {
  EXPECT_DOUBLE_EQ(melt_stirring(9.0, 0.45)(1.0), 10.0);
  EXPECT_DOUBLE_EQ(melt_stirring(9.0, 0.225)(0.9), 1.0 + 9.0 / 8.0);
  EXPECT_DOUBLE_EQ(melt_stirring(9.0, 2.0)(1.0), 20.0);
  EXPECT_DOUBLE_EQ(melt_stirring(0.0, 0.45)(1.0), 1.0) << "melt at rest";
  EXPECT_DOUBLE_EQ(melt_stirring(9.0, 0.45)(0.2), 1.0) << "held by the dendrites";
}

/// Scheil-like: most of the latent heat close below the liquidus, an eutectic at the solidus.
AlloyCard tabled_card() {
  AlloyCard card = mushy_card();
  card.liquid_fraction = against_temperature({620, 620.2, 635, 645, 649}, {0, 0.13, 0.3, 0.7, 1});
  return card;
}

TEST(ThermalProperties, LiquidFractionFollowsItsTable) {
  const AlloyCard card = tabled_card();
  const ThermalProperties metal(card);
  for (const double temperature : {600.0, 620.1, 628.0, 640.0, 648.0, 660.0}) {
    EXPECT_NEAR(metal.liquid_fraction(metal.enthalpy(temperature)),
                card.liquid_fraction(temperature), 1e-12)
        << temperature;
  }
  EXPECT_NEAR(metal.conductivity(645.0 - 1e-9),
              card.conductivity(645.0) * card.melt_conductivity_factor(0.7), 1e-6);
}

TEST(ThermalProperties, ATableOfTheLiquidFractionSetsTheWholeLatentHeatFree) {
  AlloyCard card = tabled_card();
  card.density = Curve(2500.0);
  card.specific_heat = Curve(1000.0);
  const ThermalProperties metal(card);
  EXPECT_NEAR(metal.solidification_enthalpy(), 2500.0 * (395e3 + 1000.0 * 29.0), 1.0);
}

/// The shrinkage that is left at 90 % solid is a tenth of that on freezing, whatever the solidus.
TEST(MixedByFraction, WeighsSolidAndLiquidByTheirFractions) {
  AlloyCard card = tabled_card();
  const Curve solid = against_temperature({0, 649}, {2700, 2550});
  const Curve mixed = mixed_by_fraction(card, solid, 2360.0);
  for (const double t : {100.0, 500.0, 620.0, 620.2, 627.3, 640.0, 647.0, 649.0, 700.0}) {
    const double fl = t > 649.0 ? 1.0 : card.liquid_fraction(t);
    EXPECT_NEAR(mixed(t), (1.0 - fl) * solid(std::min(t, 649.0)) + fl * 2360.0, 0.02) << t;
  }

  EXPECT_NEAR(mixed(500.0), solid(500.0), 1e-9);
  EXPECT_EQ(mixed(700.0), 2360.0);

  card.liquid_fraction = {};
  EXPECT_NEAR(mixed_by_fraction(card, solid, 2360.0)(634.5), 0.5 * solid(634.5) + 0.5 * 2360.0,
              0.05);

  card.solidus = card.liquidus;
  EXPECT_EQ(mixed_by_fraction(card, solid, 2360.0)(card.liquidus + 1.0), 2360.0);
  EXPECT_NEAR(mixed_by_fraction(card, solid, 2360.0)(card.liquidus - 1.0), 2550.0, 0.3);
}

TEST(ThermalProperties, ALinearTableIsNoTable) {
  AlloyCard card = mushy_card();
  const ThermalProperties without(card);
  card.liquid_fraction = against_temperature({620, 649}, {0, 1});
  const ThermalProperties with(card);
  for (const double temperature : {610.0, 625.0, 640.0, 660.0}) {
    EXPECT_NEAR(with.enthalpy(temperature), without.enthalpy(temperature), 1e-5);
    EXPECT_NEAR(with.kirchhoff(temperature), without.kirchhoff(temperature), 1e-8);
  }
}

}  // namespace
}  // namespace dccast::material
