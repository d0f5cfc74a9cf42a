#include "proto/values/times.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <ctime>

namespace dccast::values {
namespace {

constexpr std::int64_t noon = 1'764'244'800;  // 2025-11-27 12:00 UTC
constexpr std::int64_t hour = 3600, day = 24 * hour;

class Times : public ::testing::Test {
protected:
  void SetUp() override {
    ::setenv("TZ", "UTC", 1);
    ::tzset();
  }
};

TEST_F(Times, OfThePast) {
  EXPECT_EQ(past_time("today", noon), noon - 12 * hour);
  EXPECT_EQ(past_time("yesterday", noon), noon - 36 * hour);
  EXPECT_EQ(past_time("3 h", noon), noon - 3 * hour);
  EXPECT_EQ(past_time("30 min", noon), noon - hour / 2);
  EXPECT_EQ(past_time("1 w", noon), noon - 7 * day);
  for (const char* text : {"2025-11-27T08", "2025-11-27 08:00", "2025-11-27T08:00:00Z"})
    EXPECT_EQ(past_time(text, noon), noon - 4 * hour) << text;
}

TEST_F(Times, ToCome) {
  EXPECT_EQ(coming_time("22:00", noon), noon + 10 * hour);
  EXPECT_EQ(coming_time("08:00", noon), noon + 20 * hour);
  EXPECT_EQ(coming_time("tomorrow", noon), noon + 12 * hour);
  EXPECT_EQ(coming_time("2 d", noon), noon + 2 * day);
}

TEST_F(Times, WhatIsNoTimeIsRefused) {
  for (const char* text : {"", "banana", "2025-13-01", "2025-06-31", "2025-11-27X", "3 weeks",
                           "-3 h", "2025-11-27T25:00", "25-11-27", "3", "h"}) {
    EXPECT_EQ(past_time(text, noon), std::nullopt) << text;
    EXPECT_EQ(coming_time(text, noon), std::nullopt) << text;
  }
  EXPECT_EQ(past_time("22:00", noon), std::nullopt);
}

}  // namespace
}  // namespace dccast::values
