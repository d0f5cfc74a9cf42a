#include "core/statistics/posterior.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace dccast::statistics {
namespace {

/// Two readings of three inputs with normal noise: everything about the posterior is known.
struct Linear {
  Eigen::MatrixXd slopes = (Eigen::MatrixXd(2, 3) << 1.0, 2.0, 0.0, 0.5, -1.0, 0.0).finished();
  Eigen::Vector2d readings{1.5, -0.5};
  double noise = 0.2;

  Eigen::VectorXd likelihood(const Eigen::MatrixXd& places) const {
    const Eigen::MatrixXd off = (places * slopes.transpose()).rowwise() - readings.transpose();
    return -0.5 * off.rowwise().squaredNorm() / (noise * noise);
  }
};

TEST(Posterior, OfALinearFunctionIsExact) {
  const Linear linear;
  const auto drawn = draw_posterior(
      [&](const Eigen::MatrixXd& places) { return linear.likelihood(places); }, 3, 4000, 1);
  const double precision = 1.0 / (linear.noise * linear.noise);
  const Eigen::MatrixXd covariance =
      (precision * linear.slopes.transpose() * linear.slopes + Eigen::MatrixXd::Identity(3, 3))
          .inverse();
  const Eigen::VectorXd mean = precision * covariance * linear.slopes.transpose() * linear.readings;
  const Eigen::RowVectorXd found = drawn.places.colwise().mean();
  const Eigen::MatrixXd centred = drawn.places.rowwise() - found;
  const Eigen::MatrixXd spread = centred.transpose() * centred / 4000.0;
  for (int i = 0; i < 3; ++i) {
    const double deviation = std::sqrt(covariance(i, i));
    EXPECT_NEAR(found(i), mean(i), 0.08 * deviation) << i;
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(spread(i, j), covariance(i, j), 0.12 * deviation * std::sqrt(covariance(j, j)))
          << i << j;
  }
  // The readings are normal with this covariance before; the likelihood leaves out the noise's
  // factor.
  const Eigen::Matrix2d of_readings = linear.slopes * linear.slopes.transpose() +
                                      linear.noise * linear.noise * Eigen::Matrix2d::Identity();
  const double evidence = -0.5 * linear.readings.dot(of_readings.inverse() * linear.readings) -
                          0.5 * std::log(of_readings.determinant()) + 2.0 * std::log(linear.noise);
  EXPECT_NEAR(drawn.log_evidence, evidence, 0.15);
}

TEST(Posterior, HasBothModesOfASquare) {
  const auto drawn = draw_posterior(
      [](const Eigen::MatrixXd& places) {
        return Eigen::VectorXd(-0.5 * ((places.col(0).array().square() - 1.0) / 0.05).square());
      },
      2, 1000, 3);
  EXPECT_NEAR((drawn.places.col(0).array() > 0.0).cast<double>().mean(), 0.5, 0.15);
  EXPECT_NEAR(drawn.places.col(0).cwiseAbs().mean(), 1.0, 0.01);
  EXPECT_NEAR(drawn.places.col(1).mean(), 0.0, 0.15);  // nothing is known of it
}

/// A narrow crescent: random walks with the covariance of all draws must still go along it.
TEST(Posterior, FollowsACurvedRidge) {
  const auto drawn = draw_posterior(
      [](const Eigen::MatrixXd& places) {
        const Eigen::ArrayXd x = places.col(0), y = places.col(1);
        return Eigen::VectorXd(-0.5 * ((y - x.square()) / 0.02).square());
      },
      2, 2000, 4);
  // The posterior of x alone is proportional to exp(-x^2/2 - x^4/2).
  double norm = 0.0, square = 0.0;
  for (double x = -4.0; x < 4.0; x += 1e-3) {
    const double density = std::exp(-0.5 * x * x - 0.5 * x * x * x * x);
    norm += density;
    square += x * x * density;
  }

  EXPECT_NEAR(drawn.places.col(0).array().square().mean(), square / norm, 0.06);
  EXPECT_NEAR(drawn.places.col(0).mean(), 0.0, 0.08);
}

TEST(Posterior, WithoutObservationsIsThePrior) {
  const auto drawn = draw_posterior(
      [](const Eigen::MatrixXd& places) { return Eigen::VectorXd::Zero(places.rows()).eval(); }, 2,
      1000, 5);
  EXPECT_NEAR(drawn.log_evidence, 0.0, 1e-12);
  EXPECT_NEAR(drawn.places.array().square().mean(), 1.0, 0.12);
}

TEST(Posterior, IsTheSameEachTime) {
  const Linear linear;
  const auto again = [&] {
    return draw_posterior([&](const Eigen::MatrixXd& places) { return linear.likelihood(places); },
                          3, 200, 1);
  };
  EXPECT_EQ(again().places, again().places);
}

}  // namespace
}  // namespace dccast::statistics
