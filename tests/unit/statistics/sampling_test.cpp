#include "core/statistics/sampling.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace dccast::statistics {
namespace {

using ::testing::ElementsAre;

TEST(Sampling, SpreadsItsPlaces) {
  const auto places = latin_hypercube(10, 2, 3);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::set<int> parts;
    for (const auto& place : places) parts.insert(static_cast<int>(10 * place[axis]));
    EXPECT_EQ(parts.size(), 10u);
  }
  EXPECT_EQ(grid({2, 3}).size(), 6u);
  EXPECT_THAT(grid({2, 3})[4], ElementsAre(1, 1));
}

}  // namespace
}  // namespace dccast::statistics
