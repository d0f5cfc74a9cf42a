#include "core/mechanics/constrained_system.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/unit/linalg/grid_matrix.hpp"

namespace dccast::mechanics {
namespace {

constexpr int n = 5, unknowns = n * n;

class Constrained : public ::testing::Test {
protected:
  Constrained() { work.resize(pattern, linalg::Geometry::plane); }

  /// The same by a dense elimination of the held unknowns.
  Eigen::VectorXd dense_solution(const std::vector<double>& values) const {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd right(unknowns);
    for (int c = 0; c < unknowns; ++c) {
      for (int k = pattern.column_start()[c]; k < pattern.column_start()[c + 1]; ++k) {
        matrix(pattern.row()[k], c) = matrix(c, pattern.row()[k]) = values[k];
      }
      right(c) = -work.residual[c];
    }
    for (int i = 0; i < unknowns; ++i) {
      if (fixed[i] == 0) continue;
      matrix.row(i).setZero();
      matrix(i, i) = 1.0;
      right(i) = step[i];
    }
    return matrix.fullPivLu().solve(right);
  }

  void expect_exact() {
    const auto values = linalg::testing::grid_values(pattern, n, 0.1);
    work.stiffness = values;
    for (int i = 0; i < unknowns; ++i) work.residual[i] = std::sin(2.0 * i);
    ConstrainedSystem system(pattern, work);
    ASSERT_TRUE(system.factorize(fixed, step));
    EXPECT_TRUE(system.solve(fixed, step));
    const Eigen::VectorXd exact = dense_solution(values);
    for (int i = 0; i < unknowns; ++i) EXPECT_NEAR(work.direction[i], exact(i), 1e-13) << i;
  }

  const std::vector<int> cells = linalg::testing::grid_cells(n);
  const linalg::SparsityPattern pattern{unknowns, cells, 4};
  Workspace work;
  std::vector<char> fixed = std::vector<char>(unknowns, 0);
  std::vector<double> step = std::vector<double>(unknowns, 0.0);
};

TEST_F(Constrained, SolvesWithoutConstraints) {
  expect_exact();
}

TEST_F(Constrained, HoldsUnknownsAtZero) {
  for (int i : {0, 7, 12, 24}) fixed[i] = 1;
  expect_exact();
}

TEST_F(Constrained, MovesHeldUnknownsToTheirTargets) {
  for (int i : {0, 1, 7, 12, 13, 24}) fixed[i] = 1, step[i] = 0.3 * i - 2.0;
  expect_exact();
}

/// Once the held unknowns are there, the factor serves for more solves.
TEST_F(Constrained, LiftsOnlyOnce) {
  fixed[3] = fixed[20] = 1;
  step[3] = 1.5;
  expect_exact();

  std::fill(step.begin(), step.end(), 0.0);
  for (int i = 0; i < unknowns; ++i) work.residual[i] = std::cos(i);
  ConstrainedSystem system(pattern, work);
  work.stiffness = linalg::testing::grid_values(pattern, n, 0.1);
  ASSERT_TRUE(system.factorize(fixed, step));
  for (int repeat = 0; repeat < 2; ++repeat) {
    EXPECT_TRUE(system.solve(fixed, step));
    const auto exact = dense_solution(linalg::testing::grid_values(pattern, n, 0.1));
    for (int i = 0; i < unknowns; ++i) EXPECT_NEAR(work.direction[i], exact(i), 1e-13);
  }
}

TEST_F(Constrained, AHeldUnknownMayHaveNoStiffnessOfItsOwn) {
  fixed[12] = 1;
  work.stiffness = linalg::testing::grid_values(pattern, n, 0.1);
  work.stiffness[std::size_t(pattern.diagonal(12))] = 0.0;
  ConstrainedSystem system(pattern, work);
  EXPECT_TRUE(system.factorize(fixed, step));
  work.stiffness = linalg::testing::grid_values(pattern, n, 0.1);
  work.stiffness[std::size_t(pattern.diagonal(11))] = -1.0;
  EXPECT_FALSE(system.factorize(fixed, step)) << "a free one must have it";
}

}  // namespace
}  // namespace dccast::mechanics
