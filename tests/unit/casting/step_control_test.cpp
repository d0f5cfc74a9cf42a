#include "core/casting/step_control.hpp"

#include <gtest/gtest.h>

namespace dccast::casting {
namespace {

TEST(StepControl, TakesWhatTheCaseAsksFor) {
  StepControl control(1e-3);
  EXPECT_EQ(control.choose(2.0), 2.0);
  control.accepted();
  EXPECT_EQ(control.choose(50.0), 50.0);
}

TEST(StepControl, HalvesAfterAFailureAndGrowsBack) {
  StepControl control(0.1);
  EXPECT_TRUE(control.rejected(1.0));
  EXPECT_EQ(control.choose(1.0), 0.5);
  EXPECT_TRUE(control.rejected(0.5));
  EXPECT_EQ(control.choose(1.0), 0.25);
  control.accepted();
  EXPECT_EQ(control.choose(1.0), 0.5);
  control.accepted();
  control.accepted();
  EXPECT_EQ(control.choose(1.0), 1.0);
}

TEST(StepControl, GivesUpBelowTheSmallestStep) {
  StepControl control(0.3);
  EXPECT_TRUE(control.rejected(1.0));
  EXPECT_FALSE(control.rejected(0.5));
}

TEST(StepControl, GoesOnFromItsLimit) {
  StepControl control(0.1), other(0.1);
  EXPECT_TRUE(control.rejected(1.0));
  other.restore(control.limit());
  EXPECT_EQ(other.choose(1.0), 0.5);
}

}  // namespace
}  // namespace dccast::casting
