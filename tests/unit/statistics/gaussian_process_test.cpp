#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/sampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dccast::statistics {
namespace {

/// Smooth, with an interaction; the third input matters little.
Eigen::VectorXd smooth(const Eigen::MatrixXd& x) {
  Eigen::VectorXd y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    y(i) =
        5.0 + std::sin(3.0 * x(i, 0)) + x(i, 0) * x(i, 1) + (x.cols() > 2 ? 0.01 * x(i, 2) : 0.0);
  return y;
}

TEST(Kernel, IsMatern) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Zero(1, 1), b = Eigen::MatrixXd::Constant(1, 1, 0.6);
  const double s = std::sqrt(5.0) * 0.6 / 2.0;
  EXPECT_NEAR(correlation(a, b, Eigen::VectorXd::Constant(1, 2.0))(0, 0),
              (1.0 + s + s * s / 3.0) * std::exp(-s), 1e-15);
  EXPECT_EQ(correlation(a, a, Eigen::VectorXd::Ones(1))(0, 0), 1.0);
}

TEST(LogLikelihood, HasTheSlopeOfItsValue) {
  const Eigen::MatrixXd x = hypercube(15, 3, 5);
  const Eigen::VectorXd y = smooth(x);
  Eigen::VectorXd at(4);
  at << -0.3, 0.4, 0.1, std::log(1e-3);
  const Likelihood here = log_likelihood(x, y, at);
  for (Eigen::Index j = 0; j < 4; ++j) {
    double error[2];
    for (int half = 0; half < 2; ++half) {
      const double h = half == 0 ? 1e-2 : 5e-3;
      Eigen::VectorXd up = at, down = at;
      up(j) += h;
      down(j) -= h;
      const double slope =
          (log_likelihood(x, y, up).value - log_likelihood(x, y, down).value) / (2.0 * h);
      error[half] = std::abs(slope - here.gradient(j));
    }
    EXPECT_LT(error[1], 0.3 * error[0] + 1e-9) << j;  // of second order
  }
}

TEST(GaussianProcess, PredictsPlacesItHasNotSeen) {
  for (const int inputs : {1, 2, 3}) {
    const Eigen::MatrixXd x = hypercube(12 * inputs, inputs, 1);
    Eigen::MatrixXd with_two = Eigen::MatrixXd::Zero(x.rows(), std::max(inputs, 2));
    with_two.leftCols(inputs) = x;
    const GaussianProcess process(x, smooth(with_two));
    const Eigen::MatrixXd unseen = hypercube(200, inputs, 99);
    Eigen::MatrixXd unseen_two = Eigen::MatrixXd::Zero(200, std::max(inputs, 2));
    unseen_two.leftCols(inputs) = unseen;
    const auto estimate = process.estimate(unseen);
    const double rms = std::sqrt((estimate.mean - smooth(unseen_two)).squaredNorm() / 200.0);
    EXPECT_LT(rms, 0.01) << inputs;  // the function varies by about 1
  }
}

TEST(GaussianProcess, PassesThroughWhatItKnowsAndDoubtsWhatItDoesNot) {
  Eigen::MatrixXd x(5, 1), between(1, 1);
  x << 0.0, 0.1, 0.2, 0.3, 1.0;
  between << 0.65;
  const GaussianProcess process(x, (4.0 * x.array()).sin().matrix().col(0));
  const auto known = process.estimate(x);
  EXPECT_NEAR(known.mean(2), std::sin(0.8), 1e-4);
  EXPECT_GT(process.estimate(between).variance(0), 10.0 * known.variance.maxCoeff());
}

TEST(GaussianProcess, DoesNotFollowNoise) {
  const Eigen::MatrixXd x = hypercube(60, 1, 4);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.1);
  Eigen::VectorXd y(60);
  for (Eigen::Index i = 0; i < 60; ++i) y(i) = std::sin(3.0 * x(i, 0)) + noise(random);
  const GaussianProcess process(x, y);
  const Eigen::MatrixXd unseen = hypercube(100, 1, 8);
  const Eigen::VectorXd truth = (3.0 * unseen.array()).sin().matrix();
  EXPECT_LT(std::sqrt((process.estimate(unseen).mean - truth).squaredNorm() / 100.0), 0.06);
  EXPECT_GT(process.hyperparameters().nugget, 1e-4);
}

/// What is off without a point is what a process of the same lengths says that never had it.
TEST(GaussianProcess, LeavesPointsOutAsIfTheyHadNotBeenThere) {
  const Eigen::MatrixXd x = hypercube(20, 2, 3);
  const Eigen::VectorXd y = smooth(x);
  const GaussianProcess process(x, y);
  const Eigen::VectorXd errors = process.left_out_errors();
  const auto& shape = process.hyperparameters();
  for (const Eigen::Index out : {0, 7, 19}) {
    Eigen::MatrixXd rest(19, 2);
    Eigen::VectorXd values(19);
    for (Eigen::Index i = 0, k = 0; i < 20; ++i)
      if (i != out) rest.row(k) = x.row(i), values(k++) = y(i);
    Eigen::MatrixXd covariance = correlation(rest, rest, shape.length);
    covariance.diagonal().array() += shape.nugget;
    const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
    const Eigen::VectorXd ones = factor.solve(Eigen::VectorXd::Ones(19));
    const double mean = ones.dot(values) / ones.sum();
    const Eigen::VectorXd weights = factor.solve((values.array() - mean).matrix());
    const double said = mean + (correlation(x.row(out), rest, shape.length) * weights)(0);
    EXPECT_NEAR(errors(out), y(out) - said, 1e-7 + 1e-4 * std::abs(errors(out)));
  }
}

/// Rougher than a few points can tell from a slope, as the curl of a slab that rocks: what it says
/// of its error must hold for values it has not seen, over many such functions.
TEST(GaussianProcess, KnowsItsErrorOnAFunctionItCannotFollow) {
  constexpr int functions = 40, unseen = 50;
  double square = 0.0;
  for (int k = 0; k < functions; ++k) {
    const auto rough = [k](const Eigen::MatrixXd& x) {
      const Eigen::ArrayXd along = 11.0 * x.col(0).array() + 7.0 * x.col(1).array() + k;
      return Eigen::VectorXd(smooth(x) + (0.1 * along.sin() + 0.1 * (1.7 * along).cos()).matrix());
    };
    const Eigen::MatrixXd x = hypercube(20, 2, 100 + k), asked = hypercube(unseen, 2, 500 + k);
    const auto estimate = GaussianProcess(x, rough(x)).estimate(asked);
    const Eigen::ArrayXd off = (estimate.mean - rough(asked)).array();
    square += (off.square() / estimate.variance.array()).mean() / functions;
  }
  EXPECT_LT(std::sqrt(square), 1.3);
  EXPECT_GT(std::sqrt(square), 0.6);
}

TEST(GaussianProcess, IsConstantWhereNothingVaries) {
  const Eigen::MatrixXd x = hypercube(6, 2, 3);
  const GaussianProcess process(x, Eigen::VectorXd::Constant(6, 2.5));
  EXPECT_NEAR(process.estimate(x).mean(3), 2.5, 1e-12);
  EXPECT_NEAR(process.estimate(x).variance(3), 0.0, 1e-12);
}

}  // namespace
}  // namespace dccast::statistics
