#include "core/linalg/cholmod_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/linalg/grid_matrix.hpp"

namespace dccast::linalg {
namespace {

std::vector<double> some_vector(int size) {
  std::vector<double> x;
  for (int i = 0; i < size; ++i) x.push_back(std::cos(0.1 * i * i) + 0.3);
  return x;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

/// `solid` is factorised by supernodes after METIS, small `plane` systems by columns after AMD;
/// 90 x 90 nodes are a plane system large enough for supernodes.
struct Kind {
  int nodes_a_side;
  Geometry geometry;
};

class Solver : public ::testing::TestWithParam<Kind> {
protected:
  const int n = GetParam().nodes_a_side;
  const std::vector<int> cells = testing::grid_cells(n);
  const SparsityPattern pattern{n * n, cells, 4};
};

TEST_P(Solver, FindsTheVectorThatWasMultiplied) {
  CholmodSolver solver;
  solver.analyze(pattern, GetParam().geometry);
  EXPECT_GE(solver.factor_entries(), static_cast<double>(pattern.entries()));

  const auto x = some_vector(n * n);
  for (double shift : {0.5, 20.0}) {  // one analysis serves many factorisations
    const auto values = testing::grid_values(pattern, n, shift);
    std::vector<double> b(x.size()), found(x.size());
    multiply(pattern, values, x, b);
    ASSERT_TRUE(solver.factorize(values));
    solver.solve(b, found);
    EXPECT_LE(distance(found, x), 1e-11);
    solver.solve(b, b);
    EXPECT_EQ(b, found) << "the solution may take the place of the right-hand side";
  }
}

TEST_P(Solver, SaysSoWhenTheMatrixIsNotPositiveDefinite) {
  CholmodSolver solver;
  solver.analyze(pattern, GetParam().geometry);
  auto values = testing::grid_values(pattern, n, 0.5);
  const auto good = values;
  for (int u : {0, n * n / 2, n * n - 1}) {
    values = good;
    values[std::size_t(pattern.diagonal(u))] = -3.0;
    EXPECT_FALSE(solver.factorize(values)) << u;
    values[std::size_t(pattern.diagonal(u))] = std::nan("");
    EXPECT_FALSE(solver.factorize(values)) << u;
  }

  // A refusal leaves nothing behind.
  ASSERT_TRUE(solver.factorize(good));

  const auto x = some_vector(n * n);
  std::vector<double> b(x.size());
  multiply(pattern, good, x, b);
  solver.solve(b, b);
  EXPECT_LE(distance(b, x), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Solver,
                         ::testing::Values(Kind{30, Geometry::plane}, Kind{30, Geometry::solid},
                                           Kind{90, Geometry::plane}),
                         [](const auto& kind) {
                           return std::to_string(kind.param.nodes_a_side) +
                                  (kind.param.geometry == Geometry::plane ? "_plane" : "_solid");
                         });

TEST(CholmodSolver, BothFactorisationsGiveOneSolution) {
  constexpr int n = 40;
  const auto cells = testing::grid_cells(n);
  const SparsityPattern pattern(n * n, cells, 4);
  const auto values = testing::grid_values(pattern, n, 1e-3);
  const auto b = some_vector(n * n);
  std::vector<double> simplicial(b.size()), supernodal(b.size());
  CholmodSolver one, other;
  one.analyze(pattern, Geometry::plane);
  other.analyze(pattern, Geometry::solid);

  ASSERT_TRUE(one.factorize(values));
  ASSERT_TRUE(other.factorize(values));

  one.solve(b, simplicial);
  other.solve(b, supernodal);
  double largest = 0.0;
  for (double x : simplicial) largest = std::max(largest, std::abs(x));
  EXPECT_LE(distance(simplicial, supernodal), 1e-10 * largest);
}

TEST(CholmodSolver, TakesAnotherPatternLater) {
  CholmodSolver solver;
  for (int n : {5, 90, 12, 5}) {
    const auto cells = testing::grid_cells(n);
    const SparsityPattern pattern(n * n, cells, 4);
    const auto values = testing::grid_values(pattern, n, 1.0);
    solver.analyze(pattern);
    ASSERT_TRUE(solver.factorize(values));
    const auto x = some_vector(n * n);
    std::vector<double> b(x.size());
    multiply(pattern, values, x, b);
    solver.solve(b, b);
    EXPECT_LE(distance(b, x), 1e-11) << n;
  }
}

TEST(CholmodSolver, CanBeMoved) {
  const auto cells = testing::grid_cells(4);
  const SparsityPattern pattern(16, cells, 4);
  CholmodSolver first;
  first.analyze(pattern);
  ASSERT_TRUE(first.factorize(testing::grid_values(pattern, 4, 1.0)));
  CholmodSolver second = std::move(first);
  const auto x = some_vector(16);
  std::vector<double> b(16);
  multiply(pattern, testing::grid_values(pattern, 4, 1.0), x, b);
  second.solve(b, b);
  EXPECT_LE(distance(b, x), 1e-13);
}

}  // namespace
}  // namespace dccast::linalg
