#include "core/statistics/sampling.hpp"

#include <gtest/gtest.h>

#include <set>

namespace dccast::statistics {
namespace {

TEST(Sampling, SpreadsItsPlaces) {
  const auto places = hypercube(10, 2, 3);
  for (int axis = 0; axis < 2; ++axis) {
    std::set<int> parts;
    for (const double place : places.col(axis)) parts.insert(static_cast<int>(10 * place));
    EXPECT_EQ(parts.size(), 10u);
  }
}

TEST(Sampling, NormalBelowIsTheNormalDistribution) {
  EXPECT_DOUBLE_EQ(normal_below(0.0), 0.5);
  EXPECT_NEAR(normal_below(1.6448536), 0.95, 1e-7);
}

}  // namespace
}  // namespace dccast::statistics
