// Vertical lines as preconditioner of heat in flat cells.

#include "core/linalg/line_preconditioner.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/linalg/conjugate_gradients.hpp"
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

TEST(LinePreconditioner, SolvesUncoupledLinesExactly) {
  const FlatCells cells(0.0);
  LinePreconditioner lines(cells.pattern, cells.lines);
  ASSERT_TRUE(lines.factorize(cells.pattern, cells.values));

  std::vector<double> x(cells.b.size()), product(cells.b.size());
  lines.apply(cells.b, x);
  multiply(cells.pattern, cells.values, x, product);
  EXPECT_LE(relative_difference(product, cells.b), 1e-13);
}

/// Nodes that hardly let heat through have a diagonal that outweighs all others.
TEST(LinePreconditioner, LeavesLittleToConjugateGradientsInFlatCells) {
  FlatCells cells(0.03);
  for (int n = 0; n < cells.pattern.unknowns(); n += 17)
    cells.values[std::size_t(cells.pattern.diagonal(n))] = 1e14;
  LinePreconditioner lines(cells.pattern, cells.lines);
  ASSERT_TRUE(lines.factorize(cells.pattern, cells.values));

  ConjugateGradients gradients;
  std::vector<double> x(cells.b.size()), product(cells.b.size());
  const CgOutcome outcome =
      gradients.solve(cells.pattern, cells.values, std::vector<char>(x.size(), 0),
                      [&](std::span<const double> r, std::span<double> z) { lines.apply(r, z); },
                      cells.b, x, {1e-10, 100});
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);
  EXPECT_LE(outcome.iterations, 25);
  multiply(cells.pattern, cells.values, x, product);
  EXPECT_LE(relative_difference(product, cells.b), 1e-9);
}

TEST(LinePreconditioner, FindsALineThatIsNotPositiveDefinite) {
  FlatCells cells(0.03);
  LinePreconditioner lines(cells.pattern, cells.lines);
  cells.values[std::size_t(cells.pattern.diagonal(100))] = -1.0;
  EXPECT_FALSE(lines.factorize(cells.pattern, cells.values));
}

}  // namespace
}  // namespace dccast::linalg
