#include "proto/case_file/study_keys.hpp"

#include <gtest/gtest.h>

namespace dccast::case_file {
namespace {

TEST(Rounded, KeepsFourDigitsAndTheUnit) {
  EXPECT_EQ(rounded("0.9312345"), "0.9312");
  EXPECT_EQ(rounded("231.456 degC"), "231.5 degC");
  EXPECT_EQ(rounded("1234567 W/m2"), "1235000 W/m2");
  EXPECT_EQ(rounded("-0.000123456 K"), "-0.0001235 K");
  EXPECT_EQ(rounded("0 K"), "0 K");
}

TEST(UnitOfChange, IsThatOfTheKeyOfAFactorOrOfADifference) {
  EXPECT_EQ(unit_of_change("cooling.bottom_block.wet_gap"), "m");
  EXPECT_EQ(unit_of_change("cooling.bottom_block.wet_gap.scale"), "1");
  EXPECT_EQ(unit_of_change("schedule.casting_speed.shift"), "s");
  EXPECT_EQ(unit_of_change("schedule.casting_temperature"), "degC");
  EXPECT_EQ(unit_of_change("schedule.casting_temperature.offset"), "K");
  EXPECT_EQ(unit_of_change("title"), "");
}

}  // namespace
}  // namespace dccast::case_file
