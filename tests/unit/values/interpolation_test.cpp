#include "proto/values/interpolation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dccast::values {
namespace {

using testing::ElementsAre;

TEST(AtInstants, IsLinearBetweenAndUnknownOutside) {
  const auto found = at_instants({-1.0, 0.0, 0.5, 2.0, 3.0000001, 4.0}, {0, 1, 3}, {0, 2, 6});
  EXPECT_TRUE(std::isnan(found[0]));
  EXPECT_TRUE(std::isnan(found[5]));
  EXPECT_THAT(std::vector<double>(found.begin() + 1, found.begin() + 5), ElementsAre(0, 1, 4, 6));
}

}  // namespace
}  // namespace dccast::values
