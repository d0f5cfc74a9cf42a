#include "server/levers/sound_levers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dccast::levers {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Speed 60 mm/min, water 2e-3 rising to 4e-3 m2/s, metal of 680 °C that freezes from 645 to 575
/// °C.
v1::Case aluminium() {
  v1::Case complete;
  complete.mutable_time()->set_end_s(1e4);
  complete.mutable_cooling()->mutable_water()->set_enabled(true);
  v1::Schedule& schedule = *complete.mutable_schedule();
  schedule.mutable_casting_speed_m_per_s()->add_value(1e-3);
  schedule.mutable_casting_temperature_c()->add_value(680.0);
  v1::Curve& water = *schedule.mutable_water_flow_m2_per_s();
  water.Clear();
  water.set_abscissa(v1::TIME);
  for (const double at : {0.0, 100.0}) {
    water.add_at(at);
    water.add_value(2e-3 + 2e-5 * at);
  }
  complete.mutable_alloy()->set_liquidus_c(645.0);
  complete.mutable_alloy()->set_solidus_c(575.0);
  return complete;
}

struct Shown {
  const char* lever;
  double value;
  const char* explanation;  ///< empty: none
};

class WrongValue : public ::testing::TestWithParam<Shown> {};

TEST_P(WrongValue, IsNotPermittedAndExplained) {
  const SoundLevers sound(aluminium());
  const auto& [lever, value, explanation] = GetParam();
  EXPECT_FALSE(sound.limit_passed(lever, value).empty());
  if (*explanation == '\0')
    EXPECT_EQ(sound.explanation(lever, value), "");
  else
    EXPECT_THAT(sound.explanation(lever, value), HasSubstr(explanation));
}

constexpr const char *metal = "casting_temperature_c", *speed = "casting_speed_m_per_s",
                     *water = "water_flow_m2_per_s";

INSTANTIATE_TEST_SUITE_P(
    Levers, WrongValue,
    ::testing::Values(Shown{metal, 953.15, "if the sensor shows K, it is 680 degC"},
                      Shown{metal, 1256.0, "if the sensor shows degF, it is 680 degC"},
                      Shown{metal, 407.0, "what is read as K is in degC, it is 680.1 degC"},
                      Shown{metal, 360.0, "what is read as degF is in degC, it is 680 degC"},
                      Shown{metal, 6810.0, "ten times too large, it is 681 degC"},
                      Shown{metal, 67.5, "it is a tenth, it is 675 degC"},
                      Shown{metal, -680.0, "its sign is turned, it is 680 degC"},
                      Shown{metal, 0.0, ""}, Shown{metal, 1372.0, ""}, Shown{metal, 20.0, ""},
                      Shown{metal, 570.0, ""}, Shown{speed, 1e-2, "ten times too large"},
                      Shown{speed, 6e-2, "what is read per second is per minute"},
                      Shown{speed, -1e-3, "its sign is turned, it is 0.001 m/s"},
                      Shown{speed, 4.1e-3, ""}, Shown{speed, 1.6e-2, ""},
                      Shown{water, 3e-2, "ten times too large"},
                      Shown{water, 0.12, "what is read per second is per minute"},
                      Shown{water, 2.5, "what is read as m is in mm"}));

TEST(SoundLevers, BelieveWhatAPlantCanDo) {
  const SoundLevers sound(aluminium());
  for (const double value : {575.0, 600.0, 680.0, 760.0, 830.0})
    EXPECT_THAT(sound.limit_passed(metal, value), IsEmpty()) << value;
  for (const double value : {0.0, 1e-4, 1e-3, 2e-3, 4e-3})
    EXPECT_THAT(sound.limit_passed(speed, value), IsEmpty()) << value;
  for (const double value : {0.0, 4e-3, 16e-3})
    EXPECT_THAT(sound.limit_passed(water, value), IsEmpty()) << value;
}

TEST(SoundLevers, JudgeNoLeverThatThePlanHasNot) {
  const SoundLevers sound(aluminium());
  EXPECT_THAT(sound.limit_passed("narrow_water_flow_m2_per_s", 5.0), IsEmpty());
  EXPECT_THAT(SoundLevers(v1::Case()).limit_passed(metal, 0.0), IsEmpty());
  EXPECT_THAT(SoundLevers(v1::Case()).explanation(metal, 953.0), IsEmpty());
}

TEST(SoundLevers, JudgeTheNarrowFaceByItsOwnFlow) {
  v1::Case quarter = aluminium();
  quarter.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  quarter.mutable_schedule()->mutable_narrow_water_flow_m2_per_s()->add_value(1e-3);
  const SoundLevers sound(quarter);
  EXPECT_THAT(sound.limit_passed("narrow_water_flow_m2_per_s", 1e-2), HasSubstr("0 to 0.004 m2/s"));
  EXPECT_THAT(sound.limit_passed(water, 1e-2), IsEmpty());
}

}  // namespace
}  // namespace dccast::levers
