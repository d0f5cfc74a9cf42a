#include "core/linalg/direct_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iterator>

#include "tests/unit/linalg/grid_matrix.hpp"

namespace dccast::linalg {
namespace {

using testing::grid_cells;

std::vector<double> values_of(const SparsityPattern& pattern) {
  std::vector<double> values(pattern.entries(), -1.0);
  for (int u = 0; u < pattern.unknowns(); ++u) {
    values[std::size_t(pattern.diagonal(u))] = 9.1 + std::sin(double(u));
  }
  return values;
}

struct Outcome {
  DirectSolver::Method method;
  bool by_band;
  double error;  ///< of the solution, relative to its largest number
};

Outcome solve(const SparsityPattern& pattern, std::span<const std::vector<int>> fronts = {}) {
  const auto values = values_of(pattern);
  std::vector<double> x, b(std::size_t(pattern.unknowns()));
  for (int u = 0; u < pattern.unknowns(); ++u) x.push_back(std::cos(0.1 * u * u));
  multiply(pattern, values, x, b);
  DirectSolver solver;
  solver.analyze(pattern, Geometry::plane, fronts);
  EXPECT_TRUE(solver.factorize(values));
  solver.solve(b, b);
  EXPECT_EQ(solver.factorizations(), 1);
  EXPECT_EQ(solver.solves(), 1);
  EXPECT_GE(solver.factor_entries(), static_cast<double>(pattern.entries()));
  double error = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) error = std::max(error, std::abs(b[i] - x[i]));
  return {solver.method(), solver.uses_band(), error};
}

TEST(DirectSolver, TakesTheBandOfANarrowMeshAndCholmodOfAWideOne) {
  const auto narrow = grid_cells(30, 100), wide = grid_cells(400, 300);
  const Outcome of_narrow = solve(SparsityPattern(3000, narrow, 4));
  EXPECT_TRUE(of_narrow.by_band);
  EXPECT_LE(of_narrow.error, 1e-12);
  const Outcome of_wide = solve(SparsityPattern(120000, wide, 4));
  EXPECT_FALSE(of_wide.by_band);
  EXPECT_LE(of_wide.error, 1e-12);
}

TEST(DirectSolver, SweepsFromTheFrontThatMakesTheBandNarrow) {
  const auto flat = grid_cells(2000, 30);  // numbered along its long side
  const SparsityPattern pattern(60000, flat, 4);
  EXPECT_FALSE(solve(pattern).by_band);
  std::vector<std::vector<int>> fronts(2);
  for (int column = 0; column < 2000; ++column) fronts[0].push_back(column);
  for (int row = 0; row < 30; ++row) fronts[1].push_back(2000 * row);
  const Outcome swept = solve(pattern, fronts);
  EXPECT_TRUE(swept.by_band);
  EXPECT_LE(swept.error, 1e-12);
}

TEST(DirectSolver, ChangesTheMethodWithThePattern) {
  const auto narrow = grid_cells(10, 12), wide = grid_cells(300, 300);
  const SparsityPattern first(120, narrow, 4), second(90000, wide, 4);
  DirectSolver solver;
  for (const SparsityPattern* pattern : {&first, &second, &first}) {
    solver.analyze(*pattern);
    EXPECT_EQ(solver.uses_band(), pattern == &first);
    const auto values = values_of(*pattern);
    ASSERT_TRUE(solver.factorize(values));
    std::vector<double> x(std::size_t(pattern->unknowns()), 1.0), b(x.size());
    multiply(*pattern, values, x, b);
    solver.solve(b, b);
    for (const double found : b) ASSERT_NEAR(found, 1.0, 1e-12);
  }
  EXPECT_EQ(solver.factorizations(), 3);
}

/// A worker has one core, whatever its environment says.
TEST(CholmodSolver, StartsNoThreads) {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
  };
  const auto before = threads();
  const auto wide = grid_cells(300, 300);
  const SparsityPattern pattern(90000, wide, 4);
  CholmodSolver solver;
  solver.analyze(pattern);
  ASSERT_TRUE(solver.factorize(values_of(pattern)));
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace dccast::linalg
