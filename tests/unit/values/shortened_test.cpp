#include "proto/values/printable.hpp"

#include <gtest/gtest.h>

namespace dccast::values {
namespace {

const std::string longest(longest_echo, 'x');

TEST(Shortened, LeavesShortTextsAsTheyAre) {
  EXPECT_EQ(shortened(""), "");
  EXPECT_EQ(shortened("60 mm/min"), "60 mm/min");
  EXPECT_EQ(shortened(longest), longest);
}

TEST(Shortened, CutsLongOnesAndFurtherLines) {
  EXPECT_EQ(shortened(std::string(100000, 'x')), longest + "...");
  EXPECT_EQ(shortened("first\nsecond"), "first...");
  EXPECT_EQ(shortened("abcdef", 3), "abc...");
}

TEST(Shortened, CutsNoCharacterOfUtf8) {
  EXPECT_EQ(shortened("\u00b0\u00b0", 3), "\u00b0...");
  EXPECT_EQ(shortened("\U0001F525x", 3), "...");
}

TEST(TooLong, NamesTheTextAndTheBound) {
  EXPECT_EQ(too_long("reason", std::string(200, 'x')), "");
  EXPECT_EQ(too_long("reason", std::string(201, 'x')),
            "reason has 201 bytes; at most 200 are permitted");
}

}  // namespace
}  // namespace dccast::values
