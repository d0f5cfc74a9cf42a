#include "proto/case_file/plant_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dccast::case_file {
namespace {

using testing::HasSubstr;

TEST(PlantWords, NumbersAreAsTheUserWroteThem) {
  EXPECT_EQ(plant_number(60e3 * 0.0006666666666666668), "40");
  EXPECT_EQ(plant_number(0.1 + 0.2), "0.3");
  EXPECT_EQ(plant_number(12345.6), "12346");

  v1::Curve speed;
  speed.set_abscissa(v1::TIME);
  for (const double t : {60.0, 200.0}) speed.add_at(t);
  for (const double v : {0.0006666666666666668, 0.001}) speed.add_value(v);
  EXPECT_EQ(curve_in_words(speed, mm_per_min, "mm/min"),
            "40 mm/min to 60 s, then to 60 mm/min at 200 s");
}

TEST(PlantWords, TheWholeCaseHasNoDigitsNobodyWrote) {
  v1::Case input;
  v1::Curve& speed = *input.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::TIME);
  speed.add_at(0.0);
  speed.add_value(0.0006666666666666668);
  v1::Curve& water = *input.mutable_schedule()->mutable_water_flow_m2_per_s();
  water.add_at(0.0);
  water.add_value(0.0015);
  input.mutable_validity()->set_maximum_rotation_rad(0.17453292519943295);
  input.set_title("case 0.12345678901234567 of m/s");
  const std::string text = readable_toml(input);

  EXPECT_THAT(text, HasSubstr("\"40 mm/min\""));
  EXPECT_THAT(text, HasSubstr("\"90 l/min/m\""));
  EXPECT_THAT(text, HasSubstr("\"0.174532925 rad\""));
  EXPECT_THAT(text, HasSubstr("case 0.12345678901234567 of m/s"));
}

}  // namespace
}  // namespace dccast::case_file
