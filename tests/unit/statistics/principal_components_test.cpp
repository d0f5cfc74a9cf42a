#include "core/statistics/principal_components.hpp"
#include "core/statistics/sampling.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dccast::statistics {
namespace {

/// Histories of 20 instants that four of many inputs shape; the others matter not at all.
Eigen::MatrixXd histories(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd figures(x.rows(), 20);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index t = 0; t < 20; ++t) {
      const double time = 0.05 * static_cast<double>(t + 1);
      figures(i, t) = (30.0 + 8.0 * x(i, 0) - 4.0 * x(i, 1) + 3.0 * x(i, 0) * x(i, 2)) *
                          (1.0 - std::exp(-3.0 * time)) +
                      2.0 * x(i, 3) * time;
    }
  return figures;
}

/// The number of inputs is that of a case's uncertain figures, the number of runs that of a study
/// of drafts.
TEST(PrincipalComponents, FindTheInputsThatMatterAmongMany) {
  constexpr int inputs = 30;
  const Eigen::MatrixXd seen = hypercube(64, inputs, 1), unseen = hypercube(100, inputs, 2);
  const PrincipalComponents surface(seen, histories(seen));
  const Eigen::MatrixXd truth = histories(unseen), found = surface.means(unseen);
  const double spread_of_truth =
      std::sqrt((truth.col(19).array() - truth.col(19).mean()).square().mean());
  const double off = std::sqrt((found - truth).col(19).squaredNorm() / 100.0);
  EXPECT_LT(off, 0.25 * spread_of_truth);
  const double stated = std::sqrt(surface.left_out_errors(19).squaredNorm() / 64.0);
  EXPECT_GT(stated, 0.5 * off);
}

TEST(PrincipalComponents, GiveTheSameMeansOneByOneAndTogether) {
  const Eigen::MatrixXd seen = hypercube(20, 4, 3), unseen = hypercube(5, 4, 4);
  const PrincipalComponents surface(seen, histories(seen));
  const Eigen::MatrixXd together = surface.means(unseen);
  for (Eigen::Index i = 0; i < 5; ++i)
    EXPECT_LT((surface.estimate(unseen.row(i)).mean - together.row(i).transpose()).norm(), 1e-9);
}

}  // namespace
}  // namespace dccast::statistics
