// The preconditioner of large solids: symmetric, positive definite, as good on fine meshes as on
// coarse ones, and of the answer of a factor.

#include "core/linalg/two_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/linalg/cholmod_solver.hpp"
#include "core/linalg/conjugate_gradients.hpp"
#include "tests/support/brick_matrix.hpp"
#include "tests/unit/linalg/relative_difference.hpp"

namespace dccast::linalg {
namespace {

using support::BrickMatrix;
using testing::relative_difference;

constexpr double group = 8.0;  // rows in a coarse one

mesh::Extrusion rows_of(const BrickMatrix& brick) {
  const auto& plan = brick.plan();
  mesh::Extrusion rows;
  rows.lines = (plan[0] + 1) * (plan[1] + 1);
  for (int k = 0; k <= brick.rows(); ++k)
    rows.height.push_back(brick.coordinates()[std::size_t(3 * brick.node(0, 0, k)) + 2]);
  for (int j = 0; j < plan[1]; ++j) {
    for (int i = 0; i < plan[0]; ++i) {
      for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
        rows.cell.push_back(brick.node(i + x, j + y, 0));
    }
  }
  return rows;
}

/// A shell around liquid softer by 5e7, of one size however finely divided; it stands on the block
/// near the centre.
struct Slab {
  explicit Slab(int division, double liquid = 1e3)
      : brick({6 * division, 4 * division}, 16 * division,
              {0.03 / division, 0.03 / division, 0.004 / division}),
        held(brick.supports(2 * division)) {
    free_values = brick.stiffness(0.3, [&](int i, int j, int k) {
      const bool shell = k < 3 * division || i >= 5 * division || j >= 3 * division;
      return shell ? 5e10 : liquid;
    });
    hold();
    for (std::size_t u = 0; u < held.size(); ++u) b.push_back(1e3 * std::cos(0.1 * double(u * u)));
  }
  void hold() {
    values = free_values;
    support::decouple(brick.pattern, held, values);
  }
  TwoGrid<3> grids() const {
    TwoGrid<3> made;
    made.analyze(rows_of(brick), group);
    return made;
  }
  BrickMatrix brick;
  std::vector<char> held;
  std::vector<double> free_values, values, b;
};

CgOutcome solve(const Slab& slab, TwoGrid<3>& grids, double tolerance, std::vector<double>& x) {
  ConjugateGradients gradients;
  x.assign(slab.b.size(), 0.0);
  return gradients.solve(slab.brick.pattern, slab.free_values, slab.held,
                         [&](std::span<const double> r, std::span<double> z) { grids.apply(r, z); },
                         slab.b, x, {tolerance, 400});
}

std::vector<double> by_factor(const Slab& slab) {
  CholmodSolver solver;
  solver.analyze(slab.brick.pattern, Geometry::solid);
  EXPECT_TRUE(solver.factorize(slab.values));
  std::vector<double> free_b = slab.b, x(slab.b.size());
  for (std::size_t u = 0; u < x.size(); ++u) {
    if (slab.held[u] != 0) free_b[u] = 0.0;
  }
  solver.solve(free_b, x);
  return x;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

std::vector<double> applied(TwoGrid<3>& grids, const std::vector<double>& r) {
  std::vector<double> z(r.size());
  grids.apply(r, z);
  return z;
}

/// A vector of forces, another for every seed, zero where held.
std::vector<double> forces(const Slab& slab, int seed) {
  std::vector<double> r(slab.b.size());
  for (std::size_t u = 0; u < r.size(); ++u)
    r[u] = slab.held[u] != 0 ? 0.0 : std::sin(double(seed) + 0.3 * double(u * u % 1009));
  return r;
}

TEST(TwoGrid, IsSymmetricAndPositiveDefinite) {
  const Slab slab(1, 5e6);
  TwoGrid<3> grids = slab.grids();
  ASSERT_TRUE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
  for (int seed = 1; seed <= 5; ++seed) {
    const auto r = forces(slab, seed), s = forces(slab, seed + 100);
    const auto mr = applied(grids, r), ms = applied(grids, s);
    EXPECT_GT(dot(r, mr), 0.0);
    const double size = std::sqrt(dot(r, mr) * dot(s, ms));
    EXPECT_NEAR(dot(s, mr), dot(r, ms), 1e-5 * size) << "to single precision";
  }
}

TEST(TwoGrid, IsNearlyAFactorWhereEveryRowIsACoarseOne) {
  const Slab slab(1);
  TwoGrid<3> grids;
  grids.analyze(rows_of(slab.brick), 1.0);  // every row is a coarse one
  ASSERT_TRUE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
  std::vector<double> x;
  EXPECT_LE(solve(slab, grids, 1e-6, x).iterations, 8);
}

TEST(TwoGrid, GivesTheAnswerOfAFactor) {
  const Slab slab(1);
  TwoGrid<3> grids = slab.grids();
  ASSERT_TRUE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
  std::vector<double> x;
  const CgOutcome outcome = solve(slab, grids, 1e-13, x);
  EXPECT_EQ(outcome.end, CgOutcome::End::converged);
  EXPECT_LE(relative_difference(x, by_factor(slab)), 1e-8);
}

TEST(TwoGrid, NeedsNoMoreGradientsOnAFinerMesh) {
  int iterations[2];
  for (const int division : {1, 2}) {
    const Slab slab(division);
    TwoGrid<3> grids = slab.grids();
    ASSERT_TRUE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
    std::vector<double> x;
    const CgOutcome outcome = solve(slab, grids, 1e-6, x);
    EXPECT_EQ(outcome.end, CgOutcome::End::converged);
    iterations[division - 1] = outcome.iterations;
  }
  EXPECT_LE(iterations[1], 1.3 * iterations[0]);
  EXPECT_LE(iterations[1], 40);
}

TEST(TwoGrid, ServesOtherHeldUnknownsThanThoseItWasMadeWith) {
  Slab slab(1);
  TwoGrid<3> grids = slab.grids();
  ASSERT_TRUE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
  const auto upwards = [&](int i, int j) { return std::size_t(3 * slab.brick.node(i, j, 0) + 2); };
  slab.held[upwards(2, 1)] = 0;  // lifts off
  slab.held[upwards(3, 3)] = slab.held[upwards(4, 0)] = 1;
  slab.hold();
  std::vector<double> x;
  EXPECT_EQ(solve(slab, grids, 1e-13, x).end, CgOutcome::End::converged);
  EXPECT_LE(relative_difference(x, by_factor(slab)), 1e-8);
  EXPECT_EQ(x[upwards(3, 3)], 0.0);
}

TEST(TwoGrid, KeepsNothingOfWhatItWasUsedForBefore) {
  const Slab slab(1), other(1, 5e10);
  TwoGrid<3> used = slab.grids(), fresh = slab.grids();
  ASSERT_TRUE(used.factorize(other.brick.pattern, other.values, other.held));
  applied(used, forces(slab, 3));
  ASSERT_TRUE(used.factorize(slab.brick.pattern, slab.values, slab.held));
  ASSERT_TRUE(fresh.factorize(slab.brick.pattern, slab.values, slab.held));
  EXPECT_EQ(applied(used, forces(slab, 7)), applied(fresh, forces(slab, 7)));
}

TEST(TwoGrid, SaysThatAMatrixIsNotPositiveDefinite) {
  Slab slab(1);
  for (double& value : slab.values) value = -value;
  TwoGrid<3> grids = slab.grids();
  EXPECT_FALSE(grids.factorize(slab.brick.pattern, slab.values, slab.held));
}

}  // namespace
}  // namespace dccast::linalg
