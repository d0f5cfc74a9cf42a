#include "core/statistics/line_memory.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {
namespace {

/// A quantity at one instant: nominal 10, expected 2 above it, variance 9.
TrajectoryPrior scalar() {
  return {Eigen::VectorXd::Constant(1, 0.0), Eigen::VectorXd::Constant(1, 10.0),
          Eigen::VectorXd::Constant(1, 2.0), Eigen::MatrixXd::Constant(1, 1, 9.0)};
}

MeasuredCasting measured(double value, double noise = 0.5, double zero = 1.0) {
  return {{0}, Eigen::VectorXd::Constant(1, value), Eigen::VectorXd::Constant(1, noise), zero};
}

double variance_of(const Informed& informed) {
  return informed.prior.covariance(0, 0);
}

TEST(LineMemory, EqualsTheMeanOfCastingsInClosedForm) {
  const std::vector<MeasuredCasting> castings{measured(13.0), measured(17.0), measured(16.5)};
  const double scatter = 0.3, variance = 9.0, n = 3.0;
  const Informed informed = inform(scalar(), 1, castings, {.scatter = scatter});

  // The shared part, of variance (1 - scatter) 9, is read n times with the rest as its error.
  const double shared = (1.0 - scatter) * variance;
  const double error = scatter * variance + 0.25 + 1.0;
  const double share = shared / (shared + error / n);
  const double mean = (13.0 + 17.0 + 16.5) / n;
  EXPECT_NEAR(informed.prior.deviation(0), 2.0 + share * (mean - 12.0), 1e-12);
  EXPECT_NEAR(variance_of(informed), variance - share * shared, 1e-12);
  EXPECT_EQ(informed.prior.nominal(0), 10.0);
}

TEST(LineMemory, TheLikelihoodIsThatOfTheReadings) {
  const double variance = 9.0 + 0.25 + 1.0, common = 0.6 * 9.0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Constant(common);
  covariance.diagonal().setConstant(variance);
  const Eigen::Vector2d off(1.0, 5.0);
  const double expected =
      -0.5 * (off.dot(covariance.inverse() * off) + std::log(covariance.determinant()) +
              2.0 * std::log(2.0 * std::numbers::pi));
  const Informed informed = inform(scalar(), 1, {measured(13.0), measured(17.0)}, {.scatter = 0.4});
  EXPECT_NEAR(informed.log_likelihood, expected, 1e-12);
}

TEST(LineMemory, WithoutCastingsOrWithNothingSharedThePriorStays) {
  for (const Informed& informed :
       {inform(scalar(), 1, {}, {}), inform(scalar(), 1, {measured(30.0)}, {.scatter = 1.0}),
        inform(scalar(), 1, {measured(30.0)}, {.scatter = 0.1, .kept = 0.0})}) {
    EXPECT_EQ(informed.prior.deviation(0), 2.0);
    EXPECT_EQ(variance_of(informed), 9.0);
  }
}

TEST(LineMemory, OrderDoesNotMatterUnlessOldCastingsFade) {
  std::vector<MeasuredCasting> castings{measured(13.0), measured(17.0), measured(16.5)};
  std::vector<MeasuredCasting> turned(castings.rbegin(), castings.rend());
  const BetweenCastings lasting{.scatter = 0.3}, fading{.scatter = 0.3, .kept = 0.8};
  const auto expected = [](const std::vector<MeasuredCasting>& all,
                           const BetweenCastings& between) {
    return inform(scalar(), 1, all, between);
  };
  EXPECT_NEAR(expected(castings, lasting).prior.deviation(0),
              expected(turned, lasting).prior.deviation(0), 1e-12);
  EXPECT_NEAR(expected(castings, lasting).log_likelihood, expected(turned, lasting).log_likelihood,
              1e-12);

  // The lowest comes last: it counts most.
  EXPECT_GT(expected(castings, fading).prior.deviation(0),
            expected(turned, fading).prior.deviation(0));
  EXPECT_GT(variance_of(expected(castings, fading)), variance_of(expected(castings, lasting)));
}

/// Castings on one recipe tell data, and these another recipe: Bayesian linear regression.
TEST(LineMemory, InformsAnotherRecipeThroughTheSharedData) {
  constexpr int data = 3, next = 4, before = 5;
  std::mt19937_64 random(3);
  const auto drawn = [&] { return normal(random); };
  const Eigen::MatrixXd on_next = Eigen::MatrixXd::NullaryExpr(next, data, drawn);
  const Eigen::MatrixXd on_before = Eigen::MatrixXd::NullaryExpr(before, data, drawn);
  Eigen::MatrixXd both(next + before, data);
  both << on_next, on_before;

  const TrajectoryPrior joint{Eigen::VectorXd::LinSpaced(next + before, 0.0, 8.0),
                              Eigen::VectorXd::Zero(next + before),
                              Eigen::VectorXd::Zero(next + before), both * both.transpose()};
  const double noise = 0.4;
  MeasuredCasting casting{{},
                          Eigen::VectorXd::NullaryExpr(before, drawn),
                          Eigen::VectorXd::Constant(before, noise),
                          0.0};
  for (int i = 0; i < before; ++i) casting.instants.push_back(next + i);
  const Informed informed = inform(joint, next, {casting}, {.scatter = 0.0});

  const Eigen::MatrixXd precision =
      Eigen::MatrixXd::Identity(data, data) + on_before.transpose() * on_before / (noise * noise);
  const Eigen::MatrixXd of_data = precision.inverse();
  const Eigen::VectorXd mean = of_data * on_before.transpose() * casting.values / (noise * noise);
  EXPECT_LT((informed.prior.deviation - on_next * mean).norm(), 1e-10);
  EXPECT_LT((informed.prior.covariance - on_next * of_data * on_next.transpose()).norm(), 1e-10);
}

/// Lines whose castings have a curl of `instants` values, of which `scatter` of the variance is
/// drawn anew with each casting.
struct DrawnLines {
  static constexpr int instants = 6;
  double scatter;
  std::mt19937_64 random{11};
  BetweenCastings between{.scatter = scatter};

  Eigen::MatrixXd root() const {
    Eigen::MatrixXd shapes(instants, 2);
    for (int i = 0; i < instants; ++i) shapes.row(i) << 1.0 + i, 3.0 * std::sin(i);
    return shapes;
  }
  TrajectoryPrior prior() const {
    return {Eigen::VectorXd::LinSpaced(instants, 0.0, 5.0), Eigen::VectorXd::Zero(instants),
            Eigen::VectorXd::Zero(instants), root() * root().transpose()};
  }
  Eigen::VectorXd part() {
    return root() * Eigen::VectorXd::NullaryExpr(2, [&] { return normal(random); });
  }
  Eigen::VectorXd casting(const Eigen::VectorXd& shared) {
    return std::sqrt(1.0 - scatter) * shared + std::sqrt(scatter) * part();
  }
  MeasuredCasting readings(const Eigen::VectorXd& truth) {
    const double zero = normal(random);
    MeasuredCasting made{{}, truth, Eigen::VectorXd::Constant(instants, 0.5), 1.0};
    for (int i = 0; i < instants; ++i) {
      made.instants.push_back(i);
      made.values(i) += zero + 0.5 * normal(random);
    }
    return made;
  }
};

TEST(LineMemory, BandsOfTheNextCastingHoldNineOfTen) {
  DrawnLines drawn{.scatter = 0.2};
  constexpr int lines = 500;
  for (const int before : {1, 5}) {
    int held = 0;
    double squares = 0.0, alone = 0.0;
    for (int line = 0; line < lines; ++line) {
      const Eigen::VectorXd shared = drawn.part();
      std::vector<MeasuredCasting> castings;
      for (int i = 0; i < before; ++i) castings.push_back(drawn.readings(drawn.casting(shared)));
      const double truth = drawn.casting(shared)(5);
      const Informed next = inform(drawn.prior(), DrawnLines::instants, castings, drawn.between);
      const double off = truth - next.prior.deviation(5);
      held += std::abs(off) < 1.645 * std::sqrt(next.prior.covariance(5, 5));
      squares += off * off;
      alone += truth * truth;
    }
    std::printf("after %d castings: bands hold %d of %d, error %.2f of that without\n", before,
                held, lines, std::sqrt(squares / alone));
    EXPECT_NEAR(held, 0.9 * lines, 0.04 * lines);
    EXPECT_LT(squares, 0.6 * alone);
  }
}

TEST(LineMemory, LikelihoodsTellTheScatter) {
  const std::vector<double> assumed{0.05, 0.2, 0.8};
  for (std::size_t hidden = 0; hidden < assumed.size(); ++hidden) {
    DrawnLines drawn{.scatter = assumed[hidden]};
    const Eigen::VectorXd shared = drawn.part();
    std::vector<MeasuredCasting> castings;
    for (int i = 0; i < 60; ++i) castings.push_back(drawn.readings(drawn.casting(shared)));

    Eigen::VectorXd likelihood(assumed.size());
    for (std::size_t i = 0; i < assumed.size(); ++i)
      likelihood(i) = inform(drawn.prior(), DrawnLines::instants, castings, {.scatter = assumed[i]})
                          .log_likelihood;
    Eigen::Index likeliest;
    const Eigen::VectorXd weights = weights_of(likelihood);
    weights.maxCoeff(&likeliest);
    EXPECT_EQ(likeliest, static_cast<Eigen::Index>(hidden)) << weights.transpose();
    EXPECT_NEAR(weights.sum(), 1.0, 1e-12);
  }
}

TEST(LineMemory, AMixtureHasTheVarianceWithinAndBetween) {
  Informed low{scalar(), 0.0}, high{scalar(), 0.0};
  low.prior.deviation(0) = 1.0;
  high.prior.deviation(0) = 5.0;
  high.prior.covariance(0, 0) = 1.0;
  const TrajectoryPrior mixture = mixture_of({low, high}, Eigen::Vector2d(0.25, 0.75));
  EXPECT_NEAR(mixture.deviation(0), 4.0, 1e-12);
  EXPECT_NEAR(mixture.covariance(0, 0), 0.25 * (9.0 + 9.0) + 0.75 * (1.0 + 1.0), 1e-12);
  EXPECT_EQ(mixture.nominal(0), 10.0);

  // Likelihoods far below what a number holds.
  const Eigen::VectorXd weights = weights_of(Eigen::Vector2d(-2000.0, -2000.0 + std::log(3.0)));
  EXPECT_NEAR(weights(1), 0.75, 1e-12);
}

TEST(LineMemory, RefusesSizesThatDoNotBelongTogether) {
  MeasuredCasting casting = measured(13.0);
  casting.noise.resize(0);
  EXPECT_THROW(inform(scalar(), 1, {casting}, {}), std::invalid_argument);
  EXPECT_THROW(inform(scalar(), 2, {}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace dccast::statistics
