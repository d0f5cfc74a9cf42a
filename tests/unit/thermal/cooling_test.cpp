#include "core/thermal/cooling.hpp"

#include "tests/unit/thermal/casting_case.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace dccast::thermal {
namespace {

Water wet_side() {
  Water water = testing::water();
  water.temperature = Curve(20.0);
  return water;
}

using Law = std::function<SurfaceFlux(const SurfaceState&)>;

/// Central difference of a law in T and in the liquid fraction.
double difference(const Law& law, const SurfaceState& at, double dt, double df) {
  const double up = law({at.temperature + dt, at.liquid_fraction + df}).flux;
  const double down = law({at.temperature - dt, at.liquid_fraction - df}).flux;
  return (up - down) / (2.0 * (dt + df));
}

/// Central differences in T at two steps.
void expect_consistent_in_temperature(const Law& law, const SurfaceState& at) {
  const SurfaceFlux flux = law(at);
  const double coarse = std::abs(difference(law, at, 0.1, 0.0) - flux.d_temperature);
  const double fine = std::abs(difference(law, at, 0.05, 0.0) - flux.d_temperature);
  const double round_off = 1e-8 * (1.0 + std::abs(flux.flux));
  EXPECT_LE(fine, 0.3 * coarse + round_off) << at.temperature;
  EXPECT_LE(coarse, 1e-4 * std::abs(flux.d_temperature) + round_off) << at.temperature;
}

/// The same of a law that is linear in the liquid fraction.
void expect_consistent(const Law& law, const SurfaceState& at) {
  expect_consistent_in_temperature(law, at);
  const SurfaceFlux flux = law(at);
  EXPECT_NEAR(difference(law, at, 0.0, 0.01), flux.d_liquid_fraction,
              1e-8 * (1.0 + std::abs(flux.flux)));
}

TEST(WeckmanNiessen, MeetsTheCheckFigures) {
  const auto coefficient = [](double t) {
    return weckman_niessen(t, 20.0, 3e-3).flux / (t - 20.0);
  };
  EXPECT_NEAR(coefficient(50.0), 7.2e3, 50.0);
  EXPECT_NEAR(coefficient(100.0), 9.7e3, 50.0);
  EXPECT_NEAR(coefficient(150.0), 32e3, 500.0);
}

TEST(WeckmanNiessen, DerivativeIsConsistent) {
  for (const double t : {15.0, 60.0, 99.0, 130.0, 180.0}) {
    expect_consistent(
        [](const SurfaceState& s) { return weckman_niessen(s.temperature, 20.0, 3e-3); }, {t, 0.0});
  }
}

WaterPlace wet_place() {
  return {.film = {20.0, 3e-3}, .critical_heat_flux = 4e6, .film_coefficient = 500.0};
}

TEST(Water, IsBoundedByTheCriticalHeatFlux) {
  const Water water = wet_side();
  const auto hot = water_flux(water, wet_place(), {400.0, 0.0}, {});
  EXPECT_EQ(hot.flux, 4e6);
  EXPECT_EQ(hot.d_temperature, 0.0);
  EXPECT_EQ(water_flux(water, wet_place(), {90.0, 0.0}, {}).flux,
            weckman_niessen(90.0, 20.0, 3e-3).flux);
}

TEST(Water, IsBoundedByWhatTheFilmCanTake) {
  WaterPlace place = wet_place();
  place.largest_flux = 1e5;
  const auto flux = water_flux(wet_side(), place, {400.0, 0.0}, {});
  EXPECT_EQ(flux.flux, 1e5);
  EXPECT_EQ(flux.d_temperature, 0.0);
}

TEST(Water, MixesWetSurfaceAndVapourFilm) {
  WaterPlace place = wet_place();
  place.wetted = 0.0;
  const auto vapour = water_flux(wet_side(), place, {420.0, 0.0}, {});
  EXPECT_DOUBLE_EQ(vapour.flux, 500.0 * 400.0);
  EXPECT_DOUBLE_EQ(vapour.d_temperature, 500.0);
  place.wetted = 0.7;
  expect_consistent([&](const SurfaceState& s) { return water_flux(wet_side(), place, s, {}); },
                    {130.0, 0.0});
}

TEST(Water, TableReplacesTheLaw) {
  Water water = wet_side();
  water.coefficient = {Abscissa::temperature, {20, 100, 200}, {5000, 9000, 20000}};
  EXPECT_DOUBLE_EQ(water_flux(water, wet_place(), {60.0, 0.0}, {}).flux, 7000.0 * 40.0);
  expect_consistent([&](const SurfaceState& s) { return water_flux(water, wet_place(), s, {}); },
                    {150.0, 0.0});
}

TEST(Zone, MixesByTheLiquidFraction) {
  SideZone zone;
  zone.liquid_coefficient = Curve(2000.0);
  zone.solid_coefficient = {Abscissa::distance, {0.0, 0.03}, {150.0, 50.0}};
  EXPECT_DOUBLE_EQ(zone_flux(zone, {625.0, 1.0}, {}, 25.0).flux, 2000.0 * 600.0);
  EXPECT_DOUBLE_EQ(zone_flux(zone, {625.0, 0.0}, {0.0, 0.015}, 25.0).flux, 100.0 * 600.0);
  EXPECT_DOUBLE_EQ(zone_flux(zone, {625.0, 0.5}, {0.0, 0.015}, 25.0).flux, 1050.0 * 600.0);
  zone.temperature = Curve(125.0);
  EXPECT_DOUBLE_EQ(zone_flux(zone, {625.0, 1.0}, {}, 25.0).flux, 2000.0 * 500.0);
  zone.solid_coefficient = {Abscissa::temperature, {100, 600}, {50, 400}};
  expect_consistent([&](const SurfaceState& s) { return zone_flux(zone, s, {}, 25.0); },
                    {550.0, 0.4});
}

/// Contact and air in series, beside radiation: 1 / (1/150 + 0.5 mm / 0.05) is 60 W/(m2 K).
TEST(Zone, FollowsTheGapToTheMould) {
  SideZone zone;
  zone.liquid_coefficient = Curve(2000.0);
  zone.solid_coefficient = Curve(150.0);
  zone.gap = MouldGap{.air_conductivity = 0.05, .emissivity = 0.0};
  EXPECT_DOUBLE_EQ(zone_flux(zone, {525.0, 0.0}, {.inward = -1e-3}, 25.0).flux, 150.0 * 500.0);
  EXPECT_NEAR(zone_flux(zone, {525.0, 0.0}, {.inward = 0.5e-3}, 25.0).flux, 60.0 * 500.0, 1e-9);

  // The wall closes in by 1 mm per metre: 0.2 m down it takes 0.2 mm of the gap.
  zone.gap->taper = 1e-3;
  const SidePlace below{.distance = 0.2, .inward = 0.7e-3};
  EXPECT_NEAR(zone_flux(zone, {525.0, 0.0}, below, 25.0).flux, 60.0 * 500.0, 1e-9);

  zone.gap->emissivity = 0.3;
  const double radiation = 0.3 * 5.670374e-8 * (std::pow(798.15, 4) - std::pow(298.15, 4));
  EXPECT_NEAR(zone_flux(zone, {525.0, 0.0}, below, 25.0).flux, 60.0 * 500.0 + radiation, 1e-6);

  zone.solid_coefficient = {Abscissa::temperature, {100, 600}, {50, 400}};
  for (const double inward : {0.0, 0.5e-3}) {
    const SidePlace place{.distance = 0.02, .inward = inward};
    const Law law = [&](const SurfaceState& s) { return zone_flux(zone, s, place, 25.0); };
    const SurfaceState mush{550.0, 0.4};
    expect_consistent_in_temperature(law, mush);
    const double slope = law(mush).d_liquid_fraction;
    EXPECT_NEAR(difference(law, mush, 0.0, 1e-3), slope, 1e-4 * std::abs(slope));
  }
}

/// The shell shrinks off the block after some time of contact, however long the hold is.
TEST(BottomBlock, CountsContactFromTheFirstMetal) {
  BottomBlock block;
  block.contact_coefficient = {Abscissa::time, {25, 40}, {3000, 500}};
  block.temperature = Curve(25.0);
  block.first_metal = -60.0;
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, -35.0, 0.0), 3000.0);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, -27.5, 0.0), 1750.0);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 0.0, 0.0), 500.0);
}

TEST(BottomBlock, GoesFromContactThroughTheGap) {
  BottomBlock block;
  block.contact_coefficient = {Abscissa::time, {10, 40}, {2000, 500}};
  block.gap_coefficient = {Abscissa::gap, {0.2e-3, 5e-3, 5.5e-3}, {100, 100, 1000}};
  block.temperature = Curve(80.0);

  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 0.0, 0.0), 2000.0);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 25.0, -1e-6), 1250.0);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 100.0, 0.1e-3), 300.0);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 100.0, 1e-3), 100.0);
  EXPECT_NEAR(bottom_coefficient(block, 100.0, 5.25e-3), 550.0, 1e-9);
  EXPECT_DOUBLE_EQ(bottom_coefficient(block, 100.0, 1.0), 1000.0);

  BottomPlace place{.coefficient = 2000.0, .block = 80.0};
  EXPECT_DOUBLE_EQ(bottom_flux(block, place, {580.0, 0.0}).slab.flux, 2000.0 * 500.0);

  block.temperature_factor = {Abscissa::temperature, {300, 600}, {0.5, 1.0}};
  EXPECT_DOUBLE_EQ(bottom_flux(block, place, {450.0, 0.0}).slab.flux, 1500.0 * 370.0);
  EXPECT_DOUBLE_EQ(bottom_flux(block, place, {450.0, 0.0}).into_block, 1500.0 * 370.0);

  for (const double compliance : {0.0, 3e-4}) {
    place.compliance = compliance;
    place.wet_coefficient = 700.0;
    place.water = 25.0;
    expect_consistent([&](const SurfaceState& s) { return bottom_flux(block, place, s).slab; },
                      {450.0, 0.0});
  }
}

/// Slab, block and water exchange what each gains and loses.
TEST(BottomBlock, HeatOfAWetGapAddsUp) {
  const BottomPlace place{.coefficient = 300.0,
                          .block = 150.0,
                          .compliance = 2e-4,
                          .wet_coefficient = 900.0,
                          .water = 25.0};
  const BottomFlux flux = bottom_flux({}, place, {500.0, 0.0});
  const double block = place.block + place.compliance * flux.into_block;
  const double into_water = 900.0 * (500.0 - 25.0) + 900.0 * (block - 25.0);
  EXPECT_NEAR(flux.slab.flux, flux.into_block + into_water, 1e-9 * flux.slab.flux);
}

TEST(DrySide, IsPlainConvection) {
  CoolingSpec cooling;
  cooling.dry_coefficient = 20.0;
  cooling.ambient_temperature = 25.0;
  EXPECT_DOUBLE_EQ(dry_flux(cooling, {125.0, 0.0}).flux, 2000.0);
  EXPECT_DOUBLE_EQ(dry_flux(cooling, {125.0, 0.0}).d_temperature, 20.0);
}

}  // namespace
}  // namespace dccast::thermal
