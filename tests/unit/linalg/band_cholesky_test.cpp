#include "core/linalg/band_cholesky.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <new>

#include "core/linalg/sparsity_pattern.hpp"
#include "tests/unit/linalg/by_cholmod.hpp"
#include "tests/unit/linalg/grid_matrix.hpp"
#include "tests/unit/linalg/relative_difference.hpp"

namespace {
long allocations = 0;
}  // namespace

// Counts what the code under test asks for.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* storage = std::malloc(size)) return storage;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const std::size_t unit = static_cast<std::size_t>(alignment);
  if (void* storage = std::aligned_alloc(unit, (size + unit - 1) / unit * unit)) return storage;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* storage) noexcept {
  std::free(storage);
}
[[gnu::noinline]] void operator delete(void* storage, std::size_t) noexcept {
  std::free(storage);
}
[[gnu::noinline]] void operator delete(void* storage, std::align_val_t) noexcept {
  std::free(storage);
}
[[gnu::noinline]] void operator delete(void* storage, std::size_t, std::align_val_t) noexcept {
  std::free(storage);
}

namespace dccast::linalg {
namespace {

using testing::by_cholmod;
using testing::relative_difference;

/// A grid of n x n nodes, its matrix and a right-hand side.
struct Grid {
  explicit Grid(int nodes_a_side, double shift = 0.5)
      : n(nodes_a_side), values(testing::grid_values(pattern, n, shift)) {
    for (int i = 0; i < n * n; ++i) b.push_back(std::cos(0.1 * i * i) + 0.3);
  }
  const int n;
  const std::vector<int> cells = testing::grid_cells(n);
  const SparsityPattern pattern{n * n, cells, 4};
  const std::vector<int> backwards = reversed_order(n * n);
  std::vector<double> values, b;
};

class BandCholeskyWith : public ::testing::TestWithParam<int> {
protected:
  void SetUp() override {
    if (GetParam() >= runnable_tile_kernels().count) {
      GTEST_SKIP() << "not an instruction set of this processor";
    }
    kernels = runnable_tile_kernels().kernel[GetParam()];
  }
  BandCholesky analyzed(const Grid& grid) const {
    BandCholesky solver(*kernels);
    solver.analyze(grid.pattern, grid.backwards);
    return solver;
  }
  const TileKernels* kernels = nullptr;
};

TEST_P(BandCholeskyWith, GivesTheSolutionOfCholmod) {
  for (const int n : {1, 2, 3, 8, 11, 40, 120}) {  // the last one streams from memory
    const Grid grid(n, n < 40 ? 0.5 : 1e-3);
    BandCholesky solver = analyzed(grid);
    ASSERT_TRUE(solver.factorize(grid.values));
    std::vector<double> x = grid.b;
    solver.solve(x, x);
    EXPECT_LE(relative_difference(x, by_cholmod(grid)), 1e-12) << n;
  }
}

TEST_P(BandCholeskyWith, TakesAnyOrder) {
  const Grid grid(12);
  std::vector<int> scattered(144);
  for (int u = 0; u < 144; ++u) scattered[std::size_t(u)] = u * 35 % 144;
  BandCholesky solver(*kernels);
  solver.analyze(grid.pattern, scattered);
  ASSERT_TRUE(solver.factorize(grid.values));
  std::vector<double> x(144);
  solver.solve(grid.b, x);
  EXPECT_LE(relative_difference(x, by_cholmod(grid)), 1e-12);
}

TEST_P(BandCholeskyWith, SaysSoWhenTheMatrixIsNotPositiveDefinite) {
  const Grid grid(13);
  BandCholesky solver = analyzed(grid);
  for (const int u : {0, 84, 168}) {
    for (const double entry : {-3.0, 0.0, std::nan(""), double(INFINITY)}) {
      auto values = grid.values;
      values[std::size_t(grid.pattern.diagonal(u))] = entry;
      EXPECT_FALSE(solver.factorize(values)) << u << ' ' << entry;
    }
  }
  ASSERT_TRUE(solver.factorize(grid.values)) << "a refusal leaves nothing behind";

  std::vector<double> x(grid.b.size());
  solver.solve(grid.b, x);
  EXPECT_LE(relative_difference(x, by_cholmod(grid)), 1e-12);
}

/// Entries change in one place after another; the factor must be that of a solver which starts
/// anew.
TEST_P(BandCholeskyWith, StartsAtTheFirstChangedRowWithTheSameBits) {
  Grid grid(20);
  BandCholesky kept = analyzed(grid);
  ASSERT_TRUE(kept.factorize(grid.values));
  EXPECT_EQ(kept.share_computed(), 1.0);
  ASSERT_TRUE(kept.factorize(grid.values));
  EXPECT_EQ(kept.share_computed(), 0.0);

  for (const int u : {0, 5, 399, 200, 390, 0}) {
    grid.values[std::size_t(grid.pattern.diagonal(u))] += 0.25;
    BandCholesky anew = analyzed(grid);
    ASSERT_TRUE(kept.factorize(grid.values));
    ASSERT_TRUE(anew.factorize(grid.values));
    // The first number is eliminated last.
    EXPECT_LE(kept.share_computed(), u == 0 ? 0.02 : 1.0);
    std::vector<double> x(grid.b.size()), y(grid.b.size());
    kept.solve(grid.b, x);
    anew.solve(grid.b, y);
    EXPECT_EQ(x, y) << u;
  }
}

TEST_P(BandCholeskyWith, AllocatesNothingOnceAnalyzed) {
  const Grid grid(20), other(20, 3.0);
  BandCholesky solver = analyzed(grid);
  std::vector<double> x(grid.b.size());
  const long before = allocations;
  ASSERT_TRUE(solver.factorize(grid.values));
  solver.solve(grid.b, x);
  ASSERT_TRUE(solver.factorize(other.values));
  solver.solve(grid.b, x);
  EXPECT_EQ(allocations, before);
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, BandCholeskyWith, ::testing::Values(0, 1, 2));

TEST(BandShape, CountsTheWorkInsideTheEnvelope) {
  // 64 unknowns without any coupling: 8 tiles on the diagonal, nothing beside them.
  const std::vector<int> none;
  const SparsityPattern diagonal(64, none, 1);
  const BandShape narrow(diagonal, reversed_order(64));

  EXPECT_EQ(narrow.start.back(), 8u);
  EXPECT_EQ(narrow.flops, 8 * 1024.0);

  // All coupled with all: the lower triangle of tiles, I (I + 1) / 2 products in row I.
  std::vector<int> all(64);
  for (int u = 0; u < 64; ++u) all[std::size_t(u)] = u;
  const SparsityPattern full(64, all, 64);
  const BandShape wide(full, reversed_order(64));
  EXPECT_EQ(wide.start.back(), 36u);
  EXPECT_EQ(wide.flops, 120 * 1024.0);
}

}  // namespace
}  // namespace dccast::linalg
