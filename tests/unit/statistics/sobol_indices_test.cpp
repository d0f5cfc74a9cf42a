#include "core/statistics/sobol_indices.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace dccast::statistics {
namespace {

constexpr double pi = std::numbers::pi;

/// Ishigami and Homma 1990 with a = 7, b = 0.1, over -pi to pi.
Eigen::MatrixXd ishigami(const Eigen::MatrixXd& places) {
  const Eigen::ArrayXXd x = pi * (2.0 * places.array() - 1.0);
  return (x.col(0).sin() + 7.0 * x.col(1).sin().square() +
          0.1 * x.col(2).square().square() * x.col(0).sin())
      .matrix();
}

struct ClosedForm {
  Eigen::VectorXd first, total;
  double variance = 0.0;
};

ClosedForm exact_ishigami() {
  const double p4 = std::pow(pi, 4), p8 = p4 * p4;
  const double alone = 0.5 * std::pow(1.0 + 0.1 * p4 / 5.0, 2), second = 49.0 / 8.0;
  const double both = 0.01 * p8 * 8.0 / 225.0;
  ClosedForm exact{Eigen::Vector3d(alone, second, 0.0), Eigen::Vector3d(alone + both, second, both),
                   alone + second + both};
  exact.first /= exact.variance;
  exact.total /= exact.variance;
  return exact;
}

const Eigen::VectorXd weights = (Eigen::VectorXd(6) << 0.0, 0.5, 3.0, 9.0, 99.0, 99.0).finished();

/// Sobol's g-function: product of (|4 x - 2| + a) / (1 + a).
Eigen::MatrixXd g_function(const Eigen::MatrixXd& places) {
  Eigen::MatrixXd values = Eigen::MatrixXd::Ones(places.rows(), 1);
  for (Eigen::Index j = 0; j < places.cols(); ++j)
    values.array() *= ((4.0 * places.col(j).array() - 2.0).abs() + weights(j)) / (1.0 + weights(j));
  return values;
}

ClosedForm exact_g_function() {
  const Eigen::ArrayXd parts = 1.0 / (3.0 * (1.0 + weights.array()).square());
  const double all = (1.0 + parts).prod();
  ClosedForm exact{parts.matrix(), (parts * all / (1.0 + parts)).matrix(), all - 1.0};
  exact.first /= exact.variance;
  exact.total /= exact.variance;
  return exact;
}

/// Share of the indices that lie within twice their stated error, over many seeds.
double coverage(const SampledFunction& function, const ClosedForm& exact, int samples) {
  constexpr int seeds = 60;
  const auto inputs = static_cast<int>(exact.first.size());
  int inside = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const auto found = sobol_indices(function, inputs, samples, 1000 * (seed + 1));
    for (int j = 0; j < inputs; ++j) {
      inside += std::abs(found.first(j, 0) - exact.first(j)) <= 2.0 * found.first_error(j, 0);
      inside += std::abs(found.total(j, 0) - exact.total(j)) <= 2.0 * found.total_error(j, 0);
    }
  }
  return inside / (2.0 * inputs * seeds);
}

void expect_exact(const SampledFunction& function, const ClosedForm& exact) {
  const auto inputs = static_cast<int>(exact.first.size());
  const auto found = sobol_indices(function, inputs, 16384, 7);
  EXPECT_NEAR(found.variance(0), exact.variance, 0.02 * exact.variance);
  for (int j = 0; j < inputs; ++j) {
    EXPECT_NEAR(found.first(j, 0), exact.first(j), 0.02) << j;
    EXPECT_NEAR(found.total(j, 0), exact.total(j), 0.02) << j;
    EXPECT_LT(found.first_error(j, 0), 0.015) << j;
    EXPECT_LT(found.total_error(j, 0), 0.015) << j;
  }
}

TEST(SobolIndices, AreThoseOfIshigami) {
  expect_exact(ishigami, exact_ishigami());
}

TEST(SobolIndices, AreThoseOfTheGFunction) {
  expect_exact(g_function, exact_g_function());
}

/// Twice a standard error of 32 replicates holds 94.6 %; what stays below counts as a defect.
TEST(SobolIndices, ErrorsCoverTheTruthAsOftenAsTheySay) {
  EXPECT_GE(coverage(ishigami, exact_ishigami(), 1024), 0.93);
  EXPECT_GE(coverage(g_function, exact_g_function(), 1024), 0.93);
}

TEST(SobolIndices, AreTheSameForTheSameSeed) {
  const auto one = sobol_indices(ishigami, 3, 256, 5), other = sobol_indices(ishigami, 3, 256, 5);
  EXPECT_EQ(one.first, other.first);
  EXPECT_EQ(one.total_error, other.total_error);
  EXPECT_NE(one.first, sobol_indices(ishigami, 3, 256, 500).first);
}

TEST(SobolIndices, OfSeveralOutputsAreThoseOfEach) {
  const SampledFunction both = [](const Eigen::MatrixXd& places) {
    Eigen::MatrixXd values(places.rows(), 3);
    values.col(0) = ishigami(places);
    values.col(1) = places.col(2);
    values.col(2).setConstant(4.0);
    return values;
  };
  const auto found = sobol_indices(both, 3, 512, 5);
  EXPECT_EQ(found.total.col(0), sobol_indices(ishigami, 3, 512, 5).total.col(0));
  EXPECT_NEAR(found.first(2, 1), 1.0, 3.0 * found.first_error(2, 1));
  EXPECT_LT(found.first_error(2, 1), 0.1);
  EXPECT_NEAR(found.total(0, 1), 0.0, 1e-12);
  EXPECT_EQ(found.total.col(2).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(found.total_error.col(2).cwiseAbs().maxCoeff(), 0.0);
}

}  // namespace
}  // namespace dccast::statistics
