#include "proto/figures/rounding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "proto/figures/plant_units.hpp"

namespace dccast::figures {
namespace {

/// The examples that text, page and Python keep to.
nlohmann::json examples() {
  std::ifstream file(DCCAST_FIGURES);
  return nlohmann::json::parse(file);
}

TEST(Rounding, KeepsToTheExamplesOfAllRenderers) {
  const nlohmann::json read = examples();
  ASSERT_GT(read["curls"].size(), 10u);
  for (const nlohmann::json& example : read["curls"]) {
    const double lower_m = example.value("lower_m", NAN), upper_m = example.value("upper_m", NAN);
    const int decimals = mm_decimals(std::fmax(lower_m, upper_m));
    const std::string errors = std::isnan(upper_m) ? "" : mm_errors(lower_m, upper_m, decimals);
    EXPECT_EQ(with_errors(mm(example["curl_m"], decimals), errors) + " mm", example["text"]);
  }
}

TEST(Rounding, OfANumberThatIsNotKnown) {
  EXPECT_EQ(fixed(NAN, 1), "-");
  EXPECT_EQ(fixed(-0.04, 1), "0.0");
  EXPECT_EQ(fixed(-0.06, 1), "-0.1");
}

TEST(Rounding, DecimalsByAnErrorOfOneDigit) {
  EXPECT_EQ(decimals_by_error(0.3, 1, 6), 1);
  EXPECT_EQ(decimals_by_error(0.097, 1, 6), 1) << "is rounded to 0.1";
  EXPECT_EQ(decimals_by_error(40.0, 1, 6), 0);
  EXPECT_EQ(decimals_by_error(1e-9, 1, 6), 6);
  EXPECT_EQ(decimals_by_error(std::nullopt, 1, 6), 6);
}

TEST(PlantUnits, AreThoseOfTheContract) {
  EXPECT_EQ(plant_unit("m/s").name(), "mm/min");
  EXPECT_EQ(plant_unit("m/s").factor(), 60e3);
  EXPECT_EQ(plant_unit("1").name(), "%");
  EXPECT_EQ(plant_unit("degC").name(), "°C");
  EXPECT_EQ(plant_unit("s").name(), "s") << "stays as it is";
  EXPECT_EQ(plant_unit("s").factor(), 1.0);
}

}  // namespace
}  // namespace dccast::figures
