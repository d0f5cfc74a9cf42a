// Conjugate gradients along vertical lines, in single precision, for heat in flat cells.

#include "core/linalg/line_gradients.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/brick_matrix.hpp"
#include "tests/unit/linalg/relative_difference.hpp"

namespace dccast::linalg {
namespace {

using testing::relative_difference;

/// Conduction and storage in flat cells, with one unknown per node: the couplings of a node to its
/// neighbours, and what its diagonal has beyond these.
struct FlatCells {
  explicit FlatCells(double horizontal, double vertical = 1.0, double storage = 0.2)
      : brick({6, 4}, 16), lines(7 * 5) {
    std::vector<int> nodes;
    for (std::size_t i = 0; i < brick.cell_unknowns().size(); i += 3)
      nodes.push_back(brick.cell_unknowns()[i] / 3);
    pattern = SparsityPattern(brick.unknowns() / 3, nodes, 8);
    values.assign(pattern.entries(), 0.0);
    for (int n = 0; n < pattern.unknowns(); ++n) {
      values[std::size_t(pattern.diagonal(n))] += storage;
      for (int k = pattern.diagonal(n) + 1; k < pattern.column_start()[std::size_t(n) + 1]; ++k) {
        const int other = pattern.row()[std::size_t(k)], apart = other - n;
        const double coupling = apart == lines             ? vertical
                                : apart == 1 || apart == 7 ? horizontal
                                                           : 0.0;
        values[std::size_t(k)] = -coupling;
        values[std::size_t(pattern.diagonal(n))] += coupling;
        values[std::size_t(pattern.diagonal(other))] += coupling;
      }
      b.push_back(std::cos(double(n * n)));
    }
  }

  support::BrickMatrix brick;
  int lines;
  SparsityPattern pattern;
  std::vector<double> values, b;
};

/// Solves to the least tolerance with nothing held. @return iterations
int solve(const FlatCells& cells, std::vector<double>& x) {
  LineGradients gradients = *LineGradients::of(cells.pattern, cells.lines);
  const std::vector<char> held(cells.b.size(), 0);
  EXPECT_TRUE(gradients.factorize(cells.pattern, cells.values, held));

  x.resize(cells.b.size());
  const CgOutcome outcome = gradients.solve(cells.b, x, {LineGradients::least_tolerance, 100});
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);
  return outcome.iterations;
}

/// A x, relative to b.
double residual(const FlatCells& cells, const std::vector<double>& x) {
  std::vector<double> product(x.size());
  multiply(cells.pattern, cells.values, x, product);
  return relative_difference(product, cells.b);
}

constexpr double single_precision = 1e-5;  // [1] of a largest component

TEST(LineGradients, SolvesUncoupledLinesAtOnce) {
  const FlatCells cells(0.0);
  std::vector<double> x;
  EXPECT_EQ(solve(cells, x), 1);
  EXPECT_LE(residual(cells, x), single_precision);
}

/// Nodes that hardly let heat through have a diagonal that outweighs all others.
TEST(LineGradients, NeedsFewIterationsInFlatCells) {
  FlatCells cells(0.03);
  for (int n = 0; n < cells.pattern.unknowns(); n += 17)
    cells.values[std::size_t(cells.pattern.diagonal(n))] = 1e14;

  std::vector<double> x;
  EXPECT_LE(solve(cells, x), 12);
  EXPECT_LE(residual(cells, x), 3.0 * single_precision);
}

/// In single precision a right-hand side of 1e-30 would vanish when squared.
TEST(LineGradients, ScalesWithTheRightHandSide) {
  FlatCells cells(0.03);
  std::vector<double> large, small;
  solve(cells, large);

  for (double& b : cells.b) b *= 1e-30;
  solve(cells, small);
  for (double& x : small) x *= 1e30;
  EXPECT_LE(relative_difference(small, large), 1e-6);

  std::ranges::fill(cells.b, 0.0);
  EXPECT_EQ(solve(cells, small), 0);
  EXPECT_EQ(small, std::vector<double>(small.size(), 0.0));
}

TEST(LineGradients, ASolutionThatFailedLeavesNothingToTheNextOne) {
  const FlatCells cells(0.03);
  LineGradients gradients = *LineGradients::of(cells.pattern, cells.lines);
  ASSERT_TRUE(
      gradients.factorize(cells.pattern, cells.values, std::vector<char>(cells.b.size(), 0)));

  std::vector<double> x(cells.b.size());
  const ConjugateGradients::Limits limits{LineGradients::least_tolerance, 100};
  EXPECT_EQ(gradients.solve(std::vector<double>(x.size(), NAN), x, limits).end,
            CgOutcome::End::indefinite);
  EXPECT_EQ(gradients.solve(cells.b, x, limits).end, CgOutcome::End::converged);
  EXPECT_LE(residual(cells, x), 3.0 * single_precision);
}

/// The same as without the rows and columns of the held unknowns.
TEST(LineGradients, LeavesHeldUnknownsAtZero) {
  FlatCells cells(0.03);
  std::vector<char> held(cells.b.size(), 0);
  for (std::size_t n = 5; n < held.size(); n += 7) held[n] = 1;
  for (std::size_t n = 0; n < held.size(); ++n)
    if (held[n] != 0) cells.b[n] = 0.0;

  LineGradients gradients = *LineGradients::of(cells.pattern, cells.lines);
  ASSERT_TRUE(gradients.factorize(cells.pattern, cells.values, held));
  std::vector<double> x(held.size()), product(held.size());
  const CgOutcome outcome = gradients.solve(cells.b, x, {LineGradients::least_tolerance, 100});
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);

  multiply(cells.pattern, cells.values, x, product);
  for (std::size_t n = 0; n < held.size(); ++n) {
    if (held[n] == 0) continue;
    EXPECT_EQ(x[n], 0.0) << n;
    product[n] = 0.0;
  }
  EXPECT_LE(relative_difference(product, cells.b), single_precision);
}

TEST(LineGradients, FindsALineThatIsNotPositiveDefinite) {
  FlatCells cells(0.03);
  LineGradients gradients = *LineGradients::of(cells.pattern, cells.lines);
  cells.values[std::size_t(cells.pattern.diagonal(100))] = -1.0;
  const std::vector<char> held(cells.b.size(), 0);
  EXPECT_FALSE(gradients.factorize(cells.pattern, cells.values, held));
}

/// A plan without columns and layers has couplings on many diagonals.
TEST(LineGradients, SuitsPlansOfColumnsAndLayers) {
  const FlatCells cells(0.03);
  EXPECT_TRUE(LineGradients::of(cells.pattern, cells.lines));

  std::vector<int> pairs;
  for (int n = 1; n < 20; ++n) pairs.insert(pairs.end(), {0, n});
  EXPECT_FALSE(LineGradients::of(SparsityPattern(20, pairs, 2), 4));
}

}  // namespace
}  // namespace dccast::linalg
