#include "core/linalg/sparsity_pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/linalg/grid_matrix.hpp"

namespace dccast::linalg {
namespace {

using ::testing::ElementsAre;

TEST(SweepOrder, GoesColumnByColumnFromTheLeftEdge) {
  constexpr int n = 5;
  const auto cells = testing::grid_cells(n);
  const SparsityPattern pattern(n * n, cells, 4);
  const std::vector<int> left{0, 5, 10, 15, 20};
  const auto place = sweep_order(pattern, left);
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      EXPECT_EQ(place[std::size_t(row * n + column)], column * n + row);
    }
  }
}

TEST(SweepOrder, LeavesNothingOut) {
  const std::vector<int> pairs{0, 1, 3, 4};  // 2 and 5 stand alone
  const SparsityPattern pattern(6, pairs, 2);
  EXPECT_THAT(sweep_order(pattern, std::vector<int>{4, 4}), ElementsAre(2, 3, 4, 1, 0, 5));
  EXPECT_THAT(sweep_order(pattern, {}), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(SweepOrder, Backwards) {
  EXPECT_THAT(reversed_order(3), ElementsAre(2, 1, 0));
}

}  // namespace
}  // namespace dccast::linalg
