#include "core/linalg/condensation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/unit/linalg/relative_difference.hpp"
#include "tests/unit/linalg_contact/grid_of_springs.hpp"

namespace dccast::linalg {
namespace {

using testing::Grid;
using testing::relative_difference;

std::vector<double> emptied(const Grid& grid, std::span<const char> held) {
  std::vector<double> values = grid.values;
  for (int c = 0; c < grid.pattern.unknowns(); ++c) {
    for (int k = grid.pattern.diagonal(c) + 1; k < grid.pattern.column_start()[std::size_t(c) + 1];
         ++k) {
      const int r = grid.pattern.row()[std::size_t(k)];
      if (held[std::size_t(c)] != 0 || held[std::size_t(r)] != 0) values[std::size_t(k)] = 0.0;
    }
  }
  return values;
}

std::vector<double> by_full_factorization(const Grid& grid, std::span<const char> held) {
  DirectSolver solver;
  solver.analyze(grid.pattern);
  EXPECT_TRUE(solver.factorize(emptied(grid, held)));
  std::vector<double> x = grid.b;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (held[i] != 0) x[i] = 0.0;
  }
  solver.solve(x, x);
  return x;
}

/// Sets of held unknowns one after another: some released, some held, both, and back.
std::vector<std::vector<char>> changes(const Grid& grid) {
  std::vector<std::vector<char>> sets(4, grid.held);
  const auto flip = [&](std::vector<char>& set, int i) {
    char& h = set[std::size_t(grid.bottom[std::size_t(i)])];
    h = h != 0 ? 0 : 1;
  };
  flip(sets[0], 0);
  for (int i : {2, 3, 4}) flip(sets[1], i);
  for (int i : {0, 1, 2, 3, 5, 7}) flip(sets[2], i);
  return sets;
}

void expect_same_as_full(
    const Grid& grid, const std::function<bool(std::span<const char>)>& change,
    const std::function<void(std::span<const double>, std::span<double>)>& solve) {
  for (const auto& held : changes(grid)) {
    ASSERT_TRUE(change(held));
    std::vector<double> x(grid.b.size());
    solve(grid.b, x);
    EXPECT_LE(relative_difference(x, by_full_factorization(grid, held)), 1e-12);
  }
}

/// 12 x 12 nodes take the band, 110 x 110 CHOLMOD.
class CondensationOn : public ::testing::TestWithParam<int> {};

TEST_P(CondensationOn, MeetsFullFactorization) {
  const Grid grid(GetParam());
  DirectSolver solver;
  solver.analyze(grid.pattern);
  ASSERT_TRUE(solver.factorize(emptied(grid, grid.held)));
  Condensation condensation(8);
  condensation.start(grid.pattern, grid.values, solver, grid.held);
  expect_same_as_full(
      grid, [&](auto held) { return condensation.change(held); },
      [&](auto b, auto x) { condensation.solve(b, x); });
}

INSTANTIATE_TEST_SUITE_P(Sizes, CondensationOn, ::testing::Values(12, 110));

TEST(Condensation, RefusesToEmptyTheSetAndTooManyChanges) {
  const Grid grid(40);
  DirectSolver solver;
  solver.analyze(grid.pattern);
  std::vector<char> one = grid.held;
  for (const int u : grid.bottom) one[std::size_t(u)] = u == grid.bottom.front();
  ASSERT_TRUE(solver.factorize(emptied(grid, one)));
  Condensation condensation;
  condensation.start(grid.pattern, grid.values, solver, one);
  std::vector<char> none = one;
  none[std::size_t(grid.bottom.front())] = 0;
  EXPECT_FALSE(condensation.change(none));

  condensation.start(grid.pattern, grid.values, solver, one);
  std::vector<char> all = one;
  for (const int u : grid.bottom) all[std::size_t(u)] = 1;
  const long solves = solver.solves();
  EXPECT_FALSE(condensation.change(all));
  EXPECT_EQ(solver.solves(), solves) << "of columns that nothing uses";
}

TEST(Condensation, IsTheFactorItselfWithoutChanges) {
  const Grid grid(12);
  DirectSolver solver;
  solver.analyze(grid.pattern);
  ASSERT_TRUE(solver.factorize(emptied(grid, grid.held)));
  Condensation condensation;
  condensation.start(grid.pattern, grid.values, solver, grid.held);
  std::vector<double> x(grid.b.size());
  condensation.solve(grid.b, x);
  EXPECT_EQ(x, by_full_factorization(grid, grid.held));
  EXPECT_EQ(condensation.changes(), 0u);
}

}  // namespace
}  // namespace dccast::linalg
