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

/// Unknowns of the left and of the upper edge of a grid.
std::vector<std::vector<int>> edges_of(int columns, int rows) {
  std::vector<std::vector<int>> edges(2);
  for (int row = 0; row < rows; ++row) edges[0].push_back(columns * row);
  for (int column = 0; column < columns; ++column)
    edges[1].push_back(columns * (rows - 1) + column);
  return edges;
}

TEST(DirectSolver, DissectsAWideMeshInThePlaneWhoseEdgesItKnows) {
  const auto wide = grid_cells(150, 170);
  const SparsityPattern pattern(150 * 170, wide, 4);
  const Outcome dissected = solve(pattern, edges_of(150, 170));
  EXPECT_EQ(dissected.method, DirectSolver::Method::dissection);
  EXPECT_LE(dissected.error, 1e-12);
}

/// A mesh from a file may lack a symmetry plane or a top: distances from one edge alone cut it into
/// strips.
TEST(DirectSolver, DoesNotDissectByOneEdge) {
  const auto wide = grid_cells(150, 170);
  const SparsityPattern pattern(150 * 170, wide, 4);
  for (const std::size_t lacking : {0u, 1u}) {
    auto edges = edges_of(150, 170);
    edges[lacking].clear();
    const Outcome outcome = solve(pattern, edges);
    EXPECT_NE(outcome.method, DirectSolver::Method::dissection);
    EXPECT_LE(outcome.error, 1e-12);
  }
  const std::vector<std::vector<int>> same(2, edges_of(150, 170)[0]);
  EXPECT_NE(solve(pattern, same).method, DirectSolver::Method::dissection)
      << "two edges in one place";
}

/// A slab grows out of the band, and a checkpoint returns to it.
TEST(DirectSolver, ChangesBetweenBandAndDissection) {
  DirectSolver solver;
  for (const auto& [columns, rows] : {std::pair(12, 10), std::pair(150, 170), std::pair(12, 10)}) {
    const auto cells = grid_cells(columns, rows);
    const SparsityPattern pattern(columns * rows, cells, 4);
    solver.analyze(pattern, Geometry::plane, edges_of(columns, rows));
    EXPECT_EQ(solver.uses_band(), columns == 12);
    const auto values = values_of(pattern);
    ASSERT_TRUE(solver.factorize(values));
    std::vector<double> x(std::size_t(pattern.unknowns()), 1.0), b(x.size());
    multiply(pattern, values, x, b);
    solver.solve(b, b);
    for (const double found : b) ASSERT_NEAR(found, 1.0, 1e-12);
  }
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
