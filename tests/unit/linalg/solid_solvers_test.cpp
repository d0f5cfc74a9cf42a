// Every way to solve the elasticity of a quarter slab, on one matrix.

#include <gtest/gtest.h>

#include <cmath>

#include "core/linalg/conjugate_gradients.hpp"
#include "core/linalg/direct_solver.hpp"
#include "core/linalg/sparsity_pattern.hpp"
#include "tests/support/brick_matrix.hpp"
#include "tests/unit/linalg/relative_difference.hpp"

namespace dccast::linalg {
namespace {

using support::BrickMatrix;
using testing::relative_difference;

/// A slab on the block with a core softer by 1e6, as liquid metal is, and forces everywhere.
struct Slab {
  explicit Slab(std::array<int, 2> plan = {6, 4}, int rows = 9, double poisson = 0.3)
      : brick(plan, rows), held(brick.supports(2)) {
    free_values = brick.stiffness(poisson, [&](int i, int j, int k) {
      return k > 1 && i < plan[0] - 2 && j < plan[1] - 2 ? 5e4 : 5e10;
    });
    values = free_values;
    support::decouple(brick.pattern, held, values);
    for (std::size_t u = 0; u < held.size(); ++u) {
      b.push_back(held[u] != 0 ? 0.0 : 1e3 * std::cos(0.1 * double(u * u)));
    }
  }
  BrickMatrix brick;
  std::vector<char> held;
  std::vector<double> free_values, values, b;
};

template <class Solver>
std::vector<double> solution(Solver& solver, const std::vector<double>& values,
                             const std::vector<double>& b) {
  EXPECT_TRUE(solver.factorize(values));
  std::vector<double> x(b.size());
  solver.solve(b, x);
  return x;
}

std::vector<double> by_cholmod(const Slab& slab) {
  CholmodSolver solver;
  solver.analyze(slab.brick.pattern, Geometry::solid);
  return solution(solver, slab.values, slab.b);
}

std::vector<double> by_gradients(const Slab& slab, DirectSolver& factor, CgOutcome& outcome) {
  ConjugateGradients gradients;
  std::vector<double> x(slab.b.size());
  outcome =
      gradients.solve(slab.brick.pattern, slab.free_values, slab.held,
                      [&](std::span<const double> r, std::span<double> z) { factor.solve(r, z); },
                      slab.b, x, {1e-12, 100});
  return x;
}

TEST(SolidSolvers, ThePatternIsMadeOfNodes) {
  EXPECT_EQ(BrickMatrix({2, 3}, 2).pattern.unknowns_per_node(), 3);
}

TEST(SolidSolvers, AProductByNodesIsOneByEntries) {
  const Slab slab;
  const auto& pattern = slab.brick.pattern;
  std::vector<double> found(slab.b.size()), expected(slab.b.size(), 0.0);
  multiply(pattern, slab.free_values, slab.b, found);
  for (int c = 0; c < pattern.unknowns(); ++c) {
    for (int k = pattern.diagonal(c); k < pattern.diagonal(c + 1); ++k) {
      const std::size_t r = std::size_t(pattern.row()[std::size_t(k)]), column = std::size_t(c);
      expected[r] += slab.free_values[std::size_t(k)] * slab.b[column];
      if (r != column) expected[column] += slab.free_values[std::size_t(k)] * slab.b[r];
    }
  }
  EXPECT_LE(relative_difference(found, expected), 1e-14);
}

TEST(SolidSolvers, BandAndCholmodGiveOneSolution) {
  for (const double poisson : {0.3, 0.45}) {
    const Slab slab({6, 4}, 9, poisson);
    BandCholesky band;
    band.analyze(slab.brick.pattern, reversed_order(slab.brick.unknowns()));
    EXPECT_LE(relative_difference(solution(band, slab.values, slab.b), by_cholmod(slab)), 1e-10);
  }
}

TEST(SolidSolvers, EveryRunGivesTheSameBits) {
  const Slab slab;
  EXPECT_EQ(by_cholmod(slab), by_cholmod(slab));
  for (int repeat = 0; repeat < 2; ++repeat) {
    DirectSolver factor, other;
    for (DirectSolver* solver : {&factor, &other}) {
      solver->analyze(slab.brick.pattern, Geometry::solid);
      ASSERT_TRUE(solver->factorize(slab.values));
    }
    CgOutcome first, second;
    EXPECT_EQ(by_gradients(slab, factor, first), by_gradients(slab, other, second));
    EXPECT_EQ(first.residual, second.residual);
  }
}

TEST(SolidSolvers, TheRuleTakesTheBandOfASmallPlanAndCholmodOfAWideOne) {
  const auto uses_band = [](std::array<int, 2> plan, int rows) {
    const BrickMatrix brick(plan, rows);
    DirectSolver solver;
    solver.analyze(brick.pattern, Geometry::solid);
    EXPECT_GT(solver.memory_bytes(), 8 * std::size_t(solver.factor_entries()));
    return solver.uses_band();
  };
  EXPECT_TRUE(uses_band({8, 5}, 20));
  EXPECT_FALSE(uses_band({22, 16}, 8));
}

TEST(SolidSolvers, CholmodTakesTheNodesOfAGraphWithOneUnknownEach) {
  // The heat of a solid: one temperature a node, a chain of them here.
  std::vector<int> pair;
  for (int u = 0; u + 1 < 100; ++u) pair.insert(pair.end(), {u, u + 1});
  const SparsityPattern pattern(100, pair, 2);
  EXPECT_EQ(pattern.unknowns_per_node(), 1);

  std::vector<double> values(pattern.entries(), -1.0);
  for (int u = 0; u < 100; ++u) values[std::size_t(pattern.diagonal(u))] = 2.5;
  CholmodSolver solver;
  solver.analyze(pattern, Geometry::solid);
  const std::vector<double> ones(100, 1.0);
  std::vector<double> b(100);
  multiply(pattern, values, ones, b);
  EXPECT_LE(relative_difference(solution(solver, values, b), ones), 1e-13);
}

class MaskedGradients : public ::testing::Test {
protected:
  void SetUp() override {
    factor.analyze(slab.brick.pattern, Geometry::solid);
    ASSERT_TRUE(factor.factorize(slab.values));
  }
  /// Solution by a factorisation with the present supports.
  std::vector<double> factorized() {
    slab.values = slab.free_values;
    support::decouple(slab.brick.pattern, slab.held, slab.values);
    for (std::size_t u = 0; u < slab.b.size(); ++u) {
      if (slab.held[u] != 0) slab.b[u] = 0.0;
    }
    return by_cholmod(slab);
  }
  Slab slab;
  DirectSolver factor;
  CgOutcome outcome;
};

TEST_F(MaskedGradients, TakeOneIterationWithTheFactorOfTheMatrix) {
  const auto x = by_gradients(slab, factor, outcome);
  EXPECT_EQ(outcome.iterations, 1);
  EXPECT_LE(relative_difference(x, factorized()), 1e-10);
}

TEST_F(MaskedGradients, ReplaceAFactorisationAfterAChangeOfTheContactSet) {
  // Two nodes of the bottom lift off, three others touch down.
  for (const auto& [i, j] : {std::pair{2, 2}, {2, 1}}) {
    slab.held[std::size_t(3 * slab.brick.node(i, j, 0) + 2)] = 0;
  }
  for (const auto& [i, j] : {std::pair{6, 4}, {5, 4}, {6, 3}}) {
    slab.held[std::size_t(3 * slab.brick.node(i, j, 0) + 2)] = 1;
  }
  const auto x = by_gradients(slab, factor, outcome);
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);
  EXPECT_LE(outcome.iterations, 14);
  EXPECT_LE(relative_difference(x, factorized()), 1e-10);
}

TEST_F(MaskedGradients, SolveAnotherTangentWithTheOldFactor) {
  // A tangent of creep: shear softer here and there by up to 3.
  slab.free_values = slab.brick.stiffness(0.4, [](int i, int j, int k) {
    const double solid = 5e10 / (1.0 + (i * 7 + j * 5 + k * 3) % 3);
    return k > 1 && i < 4 && j < 2 ? 5e4 : solid;
  });
  const auto x = by_gradients(slab, factor, outcome);
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);
  EXPECT_LE(relative_difference(x, factorized()), 1e-9);
}

TEST_F(MaskedGradients, SaySoWhenTheMatrixIsIndefinite) {
  slab.free_values[std::size_t(slab.brick.pattern.diagonal(3 * slab.brick.node(6, 4, 9)))] = -1e12;
  by_gradients(slab, factor, outcome);
  EXPECT_EQ(outcome.end, CgOutcome::End::indefinite);
}

TEST_F(MaskedGradients, EndAtTheIterationsAllowed) {
  slab.free_values = slab.brick.stiffness(0.45, [](int i, int, int) { return i < 3 ? 1e4 : 1e11; });
  ConjugateGradients gradients;
  std::vector<double> x(slab.b.size());
  outcome =
      gradients.solve(slab.brick.pattern, slab.free_values, slab.held,
                      [&](std::span<const double> r, std::span<double> z) { factor.solve(r, z); },
                      slab.b, x, {1e-12, 3});
  EXPECT_EQ(outcome.end, CgOutcome::End::too_many);
  EXPECT_EQ(outcome.iterations, 3);
}

TEST_F(MaskedGradients, NothingActsNothingMoves) {
  std::ranges::fill(slab.b, 0.0);
  const auto x = by_gradients(slab, factor, outcome);
  EXPECT_EQ(outcome.iterations, 0);
  EXPECT_EQ(x, slab.b);
}

}  // namespace
}  // namespace dccast::linalg
