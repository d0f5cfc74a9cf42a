#include "core/linalg/sparsity_pattern.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/linalg/grid_matrix.hpp"

namespace dccast::linalg {
namespace {

using ::testing::ElementsAre;

/// Elements {0, 2}, {2, 1}, and {3, -1}, in which one unknown does not take part.
TEST(SparsityPattern, HasTheLowerTriangleByColumns) {
  const std::vector<int> unknown{0, 2, 2, 1, 3, -1};
  const SparsityPattern pattern(5, unknown, 2);
  EXPECT_EQ(pattern.unknowns(), 5);
  EXPECT_THAT(pattern.column_start(), ElementsAre(0, 2, 4, 5, 6, 7));
  EXPECT_THAT(pattern.row(), ElementsAre(0, 2, 1, 2, 2, 3, 4));
  for (int u = 0; u < 5; ++u) EXPECT_EQ(pattern.row()[std::size_t(pattern.diagonal(u))], u);
}

TEST(SparsityPattern, PlacesAreThoseOfTheirEntries) {
  const std::vector<int> unknown{0, 2, 2, 1, 3, -1};
  const SparsityPattern pattern(5, unknown, 2);
  EXPECT_THAT(std::vector<int>(pattern.places(0), pattern.places(0) + 4), ElementsAre(0, 1, 1, 4));
  EXPECT_THAT(std::vector<int>(pattern.places(1), pattern.places(1) + 4), ElementsAre(4, 3, 3, 2));
  EXPECT_THAT(std::vector<int>(pattern.places(2), pattern.places(2) + 4),
              ElementsAre(5, -1, -1, -1));
}

TEST(SparsityPattern, EveryPlaceOfAGridNamesItsRowAndColumn) {
  constexpr int n = 7;
  const auto unknown = testing::grid_cells(n);
  const SparsityPattern pattern(n * n, unknown, 4);
  for (int e = 0; e < (n - 1) * (n - 1); ++e) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const int place = pattern.places(e)[4 * i + j];
        const int a = unknown[std::size_t(4 * e + i)], b = unknown[std::size_t(4 * e + j)];
        EXPECT_EQ(pattern.row()[std::size_t(place)], std::max(a, b));
        EXPECT_GE(place, pattern.column_start()[std::size_t(std::min(a, b))]);
        EXPECT_LT(place, pattern.column_start()[std::size_t(std::min(a, b)) + 1]);
      }
    }
  }
}

/// Two rows of cells, then up to six at once, with one, two or three unknowns a node.
TEST(SparsityPattern, OneThatIsExtendedIsOneOfTheWholeMesh) {
  constexpr int columns = 5;
  for (const int per_node : {1, 2, 3}) {
    std::vector<int> all;
    for (const int node : testing::grid_cells(columns, 7)) {
      for (int d = 0; d < per_node; ++d) all.push_back(node * per_node + d);
    }
    const auto rows_of = [&](int rows) {
      return std::span(all).first(std::size_t(rows * (columns - 1) * 4 * per_node));
    };
    const auto unknowns = [&](int rows) { return (rows + 1) * columns * per_node; };
    SparsityPattern extended(unknowns(2), rows_of(2), 4 * per_node);
    for (const int rows : {2, 3, 6}) {
      extended.extend(unknowns(rows), rows_of(rows));
      const SparsityPattern whole(unknowns(rows), rows_of(rows), 4 * per_node);
      EXPECT_EQ(extended.column_start(), whole.column_start());
      EXPECT_EQ(extended.row(), whole.row());
      EXPECT_EQ(extended.unknowns_per_node(), per_node);
      const int places = 16 * per_node * per_node * rows * (columns - 1);
      EXPECT_TRUE(std::equal(whole.places(0), whole.places(0) + places, extended.places(0)));
    }
  }
}

TEST(SparsityPattern, ProductIsThatOfTheFullMatrix) {
  const std::vector<int> unknown{0, 2, 2, 1};
  const SparsityPattern pattern(3, unknown, 2);
  // Columns: (0,0) 2, (2,0) -1; (1,1) 3, (2,1) 5; (2,2) 7.
  const std::vector<double> values{2.0, -1.0, 3.0, 5.0, 7.0}, x{1.0, 10.0, 100.0};
  std::vector<double> y(3, 99.0);
  multiply(pattern, values, x, y);
  EXPECT_THAT(y, ElementsAre(2.0 - 100.0, 30.0 + 500.0, -1.0 + 50.0 + 700.0));
}

}  // namespace
}  // namespace dccast::linalg
