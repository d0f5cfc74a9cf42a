#include "core/thermal/water_film.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

Water water() {
  Water w = testing::water();
  w.temperature = Curve(25.0);
  w.boiling_follows_flow = true;
  w.wetting = testing::wetting();
  return w;
}

/// Pieces of 5 mm down a face of 1 m width, all at one temperature.
std::vector<WetPiece> face(double temperature, double wetted, int pieces) {
  std::vector<WetPiece> made;
  for (int i = 0; i < pieces; ++i)
    made.push_back({5e-3, {0.0, 0.065 + 5e-3 * (i + 0.5)}, temperature, wetted});
  return made;
}

double sum_of_limits(const std::vector<WaterPlace>& places, double area) {
  double sum = 0.0;
  for (const WaterPlace& place : places) sum += area * place.largest_flux;
  return sum;
}

/// The film gains the heat of the face: 180 l/min/m under a wall at 120 °C.
TEST(WaterFilm, WarmsByTheHeatThatItTakes) {
  std::vector<WaterPlace> places;
  const auto pieces = face(120.0, 1.0, 40);
  march_film(water(), {25.0, 3e-3}, 1.0, 0.01, pieces, places);
  ASSERT_EQ(places.size(), 40u);
  double heat = 0.0;
  for (std::size_t i = 0; i < 39; ++i)
    heat += 5e-3 * water_flux(water(), places[i], {120.0, 0.0}, pieces[i].at).flux;
  const double gained =
      3e-3 * water_density * water_specific_heat * (places.back().film.temperature - 25.0);
  EXPECT_NEAR(heat, gained, 1e-9 * gained);
  EXPECT_DOUBLE_EQ(places.back().film.flow, 3e-3) << "nothing evaporates below 80 °C";
}

/// In a step, all pieces together may take as much heat as the water can.
TEST(WaterFilm, NeverOffersMoreThanItsCapacity) {
  for (const double flow : {1e-5, 1e-4, 1e-3}) {
    Water w = water();
    w.wetting.least_flow = 0.0;
    w.wetting.throw_off_length = 10.0;
    std::vector<WaterPlace> places;
    march_film(w, {25.0, flow}, 1.0, 1.0, face(300.0, 1.0, 40), places);
    const double capacity = film_capacity({25.0, flow}, 1.0);
    EXPECT_NEAR(capacity, flow * water_density * (water_specific_heat * 75.0 + evaporation_heat),
                1e-9 * capacity);
    EXPECT_LE(sum_of_limits(places, 5e-3), capacity * (1.0 + 1e-12));
  }
}

TEST(WaterFilm, BoilsAwayWhereTooLittleIsLeft) {
  std::vector<WaterPlace> places;
  const FilmEnd end = march_film(water(), {25.0, 2e-4}, 1.0, 1.0, face(300.0, 1.0, 400), places);
  EXPECT_TRUE(end.boiled_away);
  EXPECT_LT(places.size(), 400u);
  EXPECT_LT(places.back().film.flow, 2e-4);
  EXPECT_LE(places.back().film.temperature, boiling_point);
}

TEST(WaterFilm, IsThrownOffAFaceThatItDoesNotWet) {
  std::vector<WaterPlace> places;
  const FilmEnd end = march_film(water(), {25.0, 5e-4}, 1.0, 1.0, face(600.0, 0.0, 100), places);
  EXPECT_TRUE(end.thrown_off);
  const double wet_length = 5e-3 * double(places.size());
  EXPECT_NEAR(wet_length, 0.02 + 0.04, 0.011);
}

/// More water takes more heat, at every flow and temperature.
TEST(WaterFilm, TakesMoreHeatFromMoreAndColderWater) {
  const auto taken = [](double flow, double temperature, double surface) {
    std::vector<WaterPlace> places;
    const auto pieces = face(surface, 0.0, 40);
    march_film(water(), {temperature, flow}, 1.0, 1000.0, pieces, places);
    double sum = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i)
      sum += 5e-3 * water_flux(water(), places[i], {surface, 0.0}, pieces[i].at).flux;
    return sum;
  };
  for (const double surface : {150.0, 300.0, 450.0, 550.0}) {
    double before = 0.0;
    for (const double flow : {2e-5, 1e-4, 3e-4, 7e-4, 1.5e-3, 3e-3, 5e-3}) {
      EXPECT_GE(taken(flow, 25.0, surface), before) << flow << ' ' << surface;
      before = taken(flow, 25.0, surface);
    }
    EXPECT_GT(taken(1.5e-3, 10.0, surface), taken(1.5e-3, 40.0, surface));
  }
}

/// dw/dt = (w_e - w) / lag, exactly: two half steps are one.
TEST(WaterFilm, WettingLagsTheSameForAnyStep) {
  const Wetting w = testing::wetting();
  const double halves = wetted_after(w, wetted_after(w, 0.2, 0.9, 0.7), 0.9, 0.7);
  EXPECT_NEAR(wetted_after(w, 0.2, 0.9, 1.4), halves, 1e-15);
}

}  // namespace
}  // namespace dccast::thermal
