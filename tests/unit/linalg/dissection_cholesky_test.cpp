#include "core/linalg/dissection_cholesky.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/linalg/cholmod_solver.hpp"
#include "tests/unit/linalg/by_cholmod.hpp"
#include "tests/unit/linalg/grid_matrix.hpp"
#include "tests/unit/linalg/relative_difference.hpp"

namespace dccast::linalg {
namespace {

using testing::by_cholmod;
using testing::relative_difference;

/// The four-node cells of a grid with some unknowns a node, its left and its upper edge, a matrix
/// and a right-hand side.
struct Grid {
  Grid(int columns, int rows, int per_node)
      : cells(unknowns_of(columns, rows, per_node)),
        pattern(columns * rows * per_node, cells, 4 * per_node),
        edges(2),
        values(pattern.entries()) {
    for (int row = 0; row < rows; ++row) add(edges[0], row * columns, per_node);
    for (int column = 0; column < columns; ++column)
      add(edges[1], (rows - 1) * columns + column, per_node);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = -0.5 + 0.3 * std::sin(double(k));
    for (int u = 0; u < pattern.unknowns(); ++u) {
      values[std::size_t(pattern.diagonal(u))] = 9.0 * per_node + std::sin(double(u));
      b.push_back(std::cos(0.1 * u * u) + 0.3);
    }
  }

  const std::vector<int> cells;
  const SparsityPattern pattern;
  std::vector<std::vector<int>> edges;
  std::vector<double> values, b;

private:
  static void add(std::vector<int>& unknowns, int node, int per_node) {
    for (int d = 0; d < per_node; ++d) unknowns.push_back(node * per_node + d);
  }
  static std::vector<int> unknowns_of(int columns, int rows, int per_node) {
    std::vector<int> unknowns;
    for (const int node : testing::grid_cells(columns, rows)) add(unknowns, node, per_node);
    return unknowns;
  }
};

std::vector<double> solution(DissectionCholesky& solver, const Grid& grid) {
  EXPECT_TRUE(solver.factorize(grid.values));
  std::vector<double> x = grid.b;
  solver.solve(x, x);
  return x;
}

DissectionCholesky analyzed(const Grid& grid, const TileKernels& kernels = best_tile_kernels()) {
  DissectionCholesky solver(kernels);
  solver.analyze(grid.pattern, DissectionTree(grid.pattern, grid.edges));
  return solver;
}

TEST(DissectionTree, HalvesAGridByItsMiddleColumn) {
  const Grid grid(31, 20, 2);
  const DissectionTree tree(grid.pattern, grid.edges);
  EXPECT_EQ(tree.unknowns_per_node, 2);
  const auto& last = tree.fronts.back();
  EXPECT_EQ(last.end - last.first, 20);
  EXPECT_TRUE(last.boundary.empty());
  for (int row = 0; row < 20; ++row) {
    const int place = tree.place[std::size_t(31 * row + 15)];
    EXPECT_GE(place, last.first);
    EXPECT_LT(place, last.end);
  }
}

TEST(DissectionTree, HasEveryNodeInOneFrontAndBoundariesBehindIt) {
  const Grid grid(40, 57, 1);
  const DissectionTree tree(grid.pattern, grid.edges);
  int next = 0;
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    const auto& front = tree.fronts[f];
    EXPECT_EQ(front.first, next);
    next = front.end;
    for (const int place : front.boundary) EXPECT_GE(place, front.end);
    for (const int child : front.children) {
      EXPECT_LT(std::size_t(child), f);
      EXPECT_EQ(tree.fronts[std::size_t(child)].depth, front.depth + 1);
    }
  }
  EXPECT_EQ(next, 40 * 57);
}

/// George's bound: the power 3/2 of the nodes, where a band takes the square.
TEST(DissectionTree, TakesLessWorkThanABandAsAMeshGrows) {
  const Grid coarse(60, 80, 2), fine(120, 160, 2);
  const double work = DissectionTree(coarse.pattern, coarse.edges).flops();
  EXPECT_LT(DissectionTree(fine.pattern, fine.edges).flops(), 8.5 * work);
}

class DissectionCholeskyWith : public ::testing::TestWithParam<int> {
protected:
  void SetUp() override {
    if (GetParam() >= runnable_tile_kernels().count) GTEST_SKIP() << "not on this processor";
    kernels_ = runnable_tile_kernels().kernel[GetParam()];
  }
  const TileKernels* kernels_ = nullptr;
};

TEST_P(DissectionCholeskyWith, GivesTheSolutionOfCholmod) {
  for (const auto& [columns, rows] : {std::pair{1, 2}, {2, 2}, {3, 40}, {37, 5}, {50, 61}}) {
    for (const int per_node : {1, 2, 3}) {
      const Grid grid(columns, rows, per_node);
      DissectionCholesky solver = analyzed(grid, *kernels_);
      EXPECT_LE(relative_difference(solution(solver, grid), by_cholmod(grid)), 1e-12)
          << columns << " x " << rows << ", " << per_node;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kernels, DissectionCholeskyWith, ::testing::Range(0, 3));

TEST(DissectionCholesky, GivesTheSameBitsInEveryFactorisation) {
  const Grid grid(33, 47, 2), other(20, 20, 2);
  DissectionCholesky solver = analyzed(grid), again = analyzed(other);
  const std::vector<double> x = solution(solver, grid);
  EXPECT_EQ(solution(solver, grid), x);
  solution(again, other);
  again.analyze(grid.pattern, DissectionTree(grid.pattern, grid.edges));
  EXPECT_EQ(solution(again, grid), x);
}

TEST(DissectionCholesky, SaysWhenAMatrixIsNotPositiveDefiniteAndGoesOn) {
  Grid grid(25, 30, 2);
  DissectionCholesky solver = analyzed(grid);
  const std::vector<double> x = solution(solver, grid);
  for (const int unknown : {0, 700, grid.pattern.unknowns() - 1}) {
    std::vector<double> values = grid.values;
    values[std::size_t(grid.pattern.diagonal(unknown))] = -1.0;
    EXPECT_FALSE(solver.factorize(values)) << unknown;
  }
  EXPECT_EQ(solution(solver, grid), x);
}

TEST(DissectionCholesky, TakesUnknownsThatNothingJoins) {
  const std::vector<int> pairs{0, 1, 3, 4};  // 2 and 5 stand alone
  const SparsityPattern pattern(6, pairs, 2);
  std::vector<double> values(pattern.entries(), -1.0);
  for (int u = 0; u < 6; ++u) values[std::size_t(pattern.diagonal(u))] = 4.0;
  DissectionCholesky solver;
  solver.analyze(pattern, DissectionTree(pattern, std::vector<std::vector<int>>{{0}, {5}}));
  ASSERT_TRUE(solver.factorize(values));
  std::vector<double> x{3.0, 3.0, 4.0, 3.0, 3.0, 4.0};
  solver.solve(x, x);
  for (const double found : x) EXPECT_NEAR(found, 1.0, 1e-14);
}

/// Two grids that nothing joins: a cut can pass between them without a node on it.
TEST(DissectionCholesky, TakesAMeshInTwoPieces) {
  constexpr int columns = 20, rows = 24, nodes = columns * rows;
  std::vector<int> cells = testing::grid_cells(columns, rows);
  const std::size_t of_one = cells.size();
  for (std::size_t i = 0; i < of_one; ++i) cells.push_back(cells[i] + nodes);
  const SparsityPattern pattern(2 * nodes, cells, 4);
  std::vector<std::vector<int>> edges(2);
  for (int row = 0; row < rows; ++row) edges[0].push_back(row * columns);
  for (int column = 0; column < columns; ++column) edges[1].push_back(nodes + column);
  std::vector<double> values(pattern.entries(), -1.0), b;
  for (int u = 0; u < pattern.unknowns(); ++u) {
    values[std::size_t(pattern.diagonal(u))] = 8.5;
    b.push_back(std::cos(0.1 * u));
  }
  DissectionCholesky solver;
  solver.analyze(pattern, DissectionTree(pattern, edges));
  CholmodSolver other;
  other.analyze(pattern);

  ASSERT_TRUE(solver.factorize(values));
  ASSERT_TRUE(other.factorize(values));

  std::vector<double> x(b.size()), expected(b.size());
  solver.solve(b, x);
  other.solve(b, expected);
  EXPECT_LE(relative_difference(x, expected), 1e-12);
}

}  // namespace
}  // namespace dccast::linalg
