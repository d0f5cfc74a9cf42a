#include "core/thermal/cooling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace dccast::thermal {
namespace {

Water wet_side() {
  Water water;
  water.temperature = Curve(20.0);
  return water;
}

/// Central differences of a law in T and in the liquid fraction, at two steps.
void expect_consistent(const std::function<SurfaceFlux(const SurfaceState&)>& law,
                       const SurfaceState& at) {
  const auto difference = [&](double dt, double df) {
    const double up = law({at.temperature + dt, at.liquid_fraction + df}).flux;
    const double down = law({at.temperature - dt, at.liquid_fraction - df}).flux;
    return (up - down) / (2.0 * (dt + df));
  };
  const SurfaceFlux flux = law(at);
  const double coarse = std::abs(difference(0.1, 0.0) - flux.d_temperature);
  const double fine = std::abs(difference(0.05, 0.0) - flux.d_temperature);
  const double round_off = 1e-8 * (1.0 + std::abs(flux.flux));
  EXPECT_LE(fine, 0.3 * coarse + round_off) << at.temperature;
  EXPECT_LE(coarse, 1e-4 * std::abs(flux.d_temperature) + round_off) << at.temperature;
  EXPECT_NEAR(difference(0.0, 0.01), flux.d_liquid_fraction, round_off);
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

TEST(Water, IsBoundedByTheCriticalHeatFlux) {
  const Water water = wet_side();
  const auto hot = water_flux(water, boiling_of(water, 3e-3, 0.0), {400.0, 0.0}, {}, 3e-3, 0.0);
  EXPECT_EQ(hot.flux, 4e6);
  EXPECT_EQ(hot.d_temperature, 0.0);
  EXPECT_EQ(water_flux(water, boiling_of(water, 3e-3, 0.0), {90.0, 0.0}, {}, 3e-3, 0.0).flux,
            weckman_niessen(90.0, 20.0, 3e-3).flux);
}

TEST(Water, FilmBoilingIsOffByDefaultAndBlendedWhenOn) {
  Water water = wet_side();
  EXPECT_EQ(film_share(water, boiling_of(water, 3e-3, 0.0), 600.0, false), 0.0);
  water.film_boiling = true;
  EXPECT_EQ(film_share(water, boiling_of(water, 3e-3, 0.0), 347.0, false), 0.0);
  EXPECT_EQ(film_share(water, boiling_of(water, 3e-3, 0.0), 350.0, false), 0.5);
  EXPECT_EQ(film_share(water, boiling_of(water, 3e-3, 0.0), 353.0, false), 1.0);
  const auto film = water_flux(water, boiling_of(water, 3e-3, 0.0), {420.0, 0.0}, {}, 3e-3, 1.0);
  EXPECT_DOUBLE_EQ(film.flux, 500.0 * 400.0);
  EXPECT_DOUBLE_EQ(film.d_temperature, 500.0);
  expect_consistent(
      [&](const SurfaceState& s) {
        return water_flux(water, boiling_of(water, 3e-3, 0.0), s, {}, 3e-3, 0.3);
      },
      {130.0, 0.0});
}

TEST(Water, TableReplacesTheLaw) {
  Water water = wet_side();
  water.coefficient = {Abscissa::temperature, {20, 100, 200}, {5000, 9000, 20000}};
  EXPECT_DOUBLE_EQ(water_flux(water, boiling_of(water, 3e-3, 0.0), {60.0, 0.0}, {}, 3e-3, 0.0).flux,
                   7000.0 * 40.0);
  expect_consistent(
      [&](const SurfaceState& s) {
        return water_flux(water, boiling_of(water, 3e-3, 0.0), s, {}, 3e-3, 0.0);
      },
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
  EXPECT_DOUBLE_EQ(bottom_flux(block, {580.0, 0.0}, 0.0, 0.0).flux, 2000.0 * 500.0);
  block.temperature_factor = {Abscissa::temperature, {300, 600}, {0.5, 1.0}};
  EXPECT_DOUBLE_EQ(bottom_flux(block, {450.0, 0.0}, 0.0, 0.0).flux, 1500.0 * 370.0);
  expect_consistent([&](const SurfaceState& s) { return bottom_flux(block, s, 0.0, 0.0); },
                    {450.0, 0.0});
}

TEST(DrySide, IsPlainConvection) {
  CoolingSpec cooling;
  EXPECT_DOUBLE_EQ(dry_flux(cooling, {125.0, 0.0}).flux, 2000.0);
  EXPECT_DOUBLE_EQ(dry_flux(cooling, {125.0, 0.0}).d_temperature, 20.0);
}

}  // namespace
}  // namespace dccast::thermal
