#include "core/base/errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dccast {
namespace {

using ::testing::HasSubstr;

TEST(Errors, AnInvalidCaseNamesAllFaultsAtOnce) {
  Faults faults;
  EXPECT_TRUE(faults.empty());

  faults.add("schedule.casting_speed", -0.001, "must be positive", "more than 0 m/s",
             "drop the sign");
  faults.add("alloy.card", "aa9999", "is not an alloy this server knows");
  const InvalidCase error(faults);
  ASSERT_EQ(error.faults().size(), 2u);
  EXPECT_EQ(error.faults()[0].field, "schedule.casting_speed");
  EXPECT_EQ(error.faults()[0].value, "-0.001");
  EXPECT_EQ(error.faults()[0].permitted, "more than 0 m/s");
  EXPECT_EQ(error.faults()[0].remedy, "drop the sign");
  EXPECT_THAT(error.what(), HasSubstr("schedule.casting_speed = -0.001: must be positive"));
  EXPECT_THAT(error.what(), HasSubstr("alloy.card = aa9999: is not an alloy"));
}

TEST(Errors, AFailedSolveKeepsItsHistory) {
  const SolveFailed error("no convergence", 12.5, 0.25, {1.0, 0.3, 0.2});
  EXPECT_STREQ(error.what(), "no convergence");
  EXPECT_EQ(error.time(), 12.5);
  EXPECT_EQ(error.time_step(), 0.25);
  EXPECT_THAT(error.residual_history(), ::testing::ElementsAre(1.0, 0.3, 0.2));
}

}  // namespace
}  // namespace dccast
