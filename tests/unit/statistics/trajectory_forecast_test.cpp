#include "core/statistics/trajectory_forecast.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::statistics {
namespace {

constexpr int instants = 41;
constexpr Gauge gauge{.noise = 0.7, .zero = 1.5};

Eigen::VectorXd times() {
  return Eigen::VectorXd::LinSpaced(instants, 0.0, 200.0);
}

Eigen::VectorXd nominal() {
  return 30.0 * (1.0 - (-times().array() / 60.0).exp());
}

/// Deviations with a mean that is not zero and a smooth correlation.
TrajectoryPrior prior() {
  const Eigen::VectorXd deviation = 0.1 * nominal();
  const Eigen::VectorXd scale = 0.2 * nominal().array() + 0.5;
  const Eigen::VectorXd length = Eigen::VectorXd::Constant(1, 80.0);
  const Eigen::MatrixXd covariance =
      scale.asDiagonal() * correlation(times(), times(), length) * scale.asDiagonal();
  return {times(), nominal(), deviation, covariance};
}

/// A trajectory drawn from the prior.
Eigen::VectorXd drawn_truth(const TrajectoryPrior& from, std::mt19937_64& random) {
  const Eigen::MatrixXd regular =
      from.covariance + 1e-9 * Eigen::MatrixXd::Identity(instants, instants);
  const Eigen::VectorXd numbers =
      Eigen::VectorXd::NullaryExpr(instants, [&](Eigen::Index) { return normal(random); });
  return from.nominal + from.deviation + regular.llt().matrixL() * numbers;
}

TEST(TrajectoryForecast, OneReadingAfterAnotherEqualsAllAtOnce) {
  const TrajectoryPrior p = prior();
  TrajectoryForecast forecast(p, gauge);
  const Eigen::Vector3i read(3, 11, 12);
  const Eigen::Vector3d values(9.0, 24.0, 22.0);
  for (int i = 0; i < 3; ++i) forecast.learn(p.time(read(i)), values(i));

  // Gaussian conditioning on the vector of readings, their common zero as a part of their noise.
  Eigen::Matrix3d of_readings = Eigen::Matrix3d::Constant(gauge.zero * gauge.zero);
  of_readings.diagonal().array() += gauge.noise * gauge.noise;
  Eigen::MatrixXd with_readings(instants, 3);
  Eigen::Vector3d surprise;
  for (int i = 0; i < 3; ++i) {
    with_readings.col(i) = p.covariance.col(read(i));
    surprise(i) = values(i) - p.nominal(read(i)) - p.deviation(read(i));
    for (int j = 0; j < 3; ++j) of_readings(i, j) += p.covariance(read(i), read(j));
  }
  const Eigen::MatrixXd gain = of_readings.llt().solve(with_readings.transpose()).transpose();
  const Eigen::VectorXd mean = p.nominal + p.deviation + gain * surprise;
  const Eigen::MatrixXd covariance = p.covariance - gain * with_readings.transpose();

  for (Eigen::Index i = 0; i < instants; ++i) {
    EXPECT_NEAR(forecast.at(p.time(i)).value, mean(i), 1e-10);
    EXPECT_NEAR(forecast.at(p.time(i)).deviation, std::sqrt(covariance(i, i)), 1e-10);
  }
}

TEST(TrajectoryForecast, BandsHoldNineTruthsOfTenAndReadingsNarrowThem) {
  const TrajectoryPrior p = prior();
  std::mt19937_64 random(7);
  int held = 0, asked = 0;
  double before = 0.0, after = 0.0;

  for (int casting = 0; casting < 300; ++casting) {
    const Eigen::VectorXd truth = drawn_truth(p, random);
    const double zero = gauge.zero * normal(random);
    TrajectoryForecast forecast(p, gauge);
    before += forecast.at(160.0).deviation;

    for (Eigen::Index i = 4; i <= 20; ++i)
      forecast.learn(p.time(i), truth(i) + zero + gauge.noise * normal(random));

    const Estimated in_one_minute = forecast.at(160.0);
    after += in_one_minute.deviation;
    held += std::abs(truth(32) - in_one_minute.value) <= 1.645 * in_one_minute.deviation;
    ++asked;
  }
  EXPECT_NEAR(static_cast<double>(held) / asked, 0.90, 3.0 * std::sqrt(0.9 * 0.1 / 300.0));
  EXPECT_LT(after, 0.7 * before);
}

TEST(TrajectoryForecast, FindsTheZeroOfAGaugeOnlyWherePriorAndReadingsPermit) {
  TrajectoryPrior certain = prior();
  certain.covariance *= 1e-6;
  TrajectoryForecast forecast(certain, gauge);
  for (Eigen::Index i = 0; i < instants; ++i)
    forecast.learn(certain.time(i), certain.nominal(i) + certain.deviation(i) + 2.0);
  EXPECT_NEAR(forecast.zero().value, 2.0, 0.02);
  EXPECT_NEAR(forecast.zero().deviation, gauge.noise / std::sqrt(instants), 0.01);
  EXPECT_NEAR(forecast.at(200.0).value, certain.nominal(40) + certain.deviation(40), 0.1);

  TrajectoryForecast exact(prior(), {.noise = 0.5, .zero = 0.0});
  exact.learn(100.0, 70.0);
  EXPECT_EQ(exact.zero().value, 0.0);
  EXPECT_EQ(exact.zero().deviation, 0.0);
}

TEST(TrajectoryForecast, InterpolatesBetweenInstantsAndEndsWithTheLast) {
  const TrajectoryPrior p = prior();
  const TrajectoryForecast forecast(p, gauge);
  const double half = 0.5 * (forecast.at(50.0).value + forecast.at(55.0).value);
  EXPECT_NEAR(forecast.at(52.5).value, half, 1e-12);
  EXPECT_EQ(forecast.at(900.0).value, forecast.at(200.0).value);
  EXPECT_EQ(forecast.at(-3.0).value, forecast.at(0.0).value);

  const Estimated reading = forecast.expected_reading(200.0);
  const double own = forecast.at(200.0).deviation;
  EXPECT_NEAR(reading.deviation, std::hypot(own, gauge.noise, gauge.zero), 1e-10);
}

/// Members that are the nominal run times a factor.
TrajectoryEnsemble scaled_members(int count) {
  TrajectoryEnsemble ensemble{times(), nominal(), {}, {}, 0.0};
  ensemble.members.resize(count, instants);
  for (int i = 0; i < count; ++i)
    ensemble.members.row(i) = (1.0 + 0.02 * (i - 3)) * nominal().transpose();
  return ensemble;
}

TEST(TrajectoryPrior, HasMeanAndSpreadOfTheMembers) {
  const TrajectoryEnsemble ensemble = scaled_members(9);
  const TrajectoryPrior p = prior_of(ensemble);
  // Factors 0.94 to 1.10: mean 1.02, variance 0.02^2 times that of 1 to 9, which is 7.5.
  EXPECT_LT((p.deviation - 0.02 * nominal()).norm(), 1e-12);
  const double variance = (1.0 + 1.0 / 9.0) * 7.5 * 0.02 * 0.02;
  EXPECT_NEAR(p.covariance(40, 40), variance * nominal()(40) * nominal()(40), 1e-10);
  EXPECT_NEAR(p.covariance(40, 8), variance * nominal()(40) * nominal()(8), 1e-10);
}

TEST(TrajectoryPrior, AddsTheMisfitOfTheMeshAndTheErrorOfTheModel) {
  TrajectoryEnsemble ensemble = scaled_members(9);
  const TrajectoryPrior without = prior_of(ensemble);

  ensemble.misfits.resize(2, instants);
  ensemble.misfits.row(0).setConstant(0.5);
  ensemble.misfits.row(1).setConstant(1.5);
  const TrajectoryPrior with_mesh = prior_of(ensemble);
  EXPECT_LT((with_mesh.deviation - without.deviation).cwiseAbs().maxCoeff(), 1.0 + 1e-12);
  EXPECT_NEAR(with_mesh.deviation(7) - without.deviation(7), 1.0, 1e-12);
  const Eigen::MatrixXd added = with_mesh.covariance - without.covariance;
  EXPECT_NEAR(added(5, 5), 0.5, 1e-10);
  EXPECT_NEAR(added(0, 12), 0.25 + 0.25 * std::exp(-1.0), 1e-10);  // 60 s apart

  ensemble.misfits.resize(0, 0);
  ensemble.model_error = 0.05;
  const Eigen::MatrixXd of_model = prior_of(ensemble).covariance - without.covariance;
  const double error = 0.05 * 1.02 * nominal()(40);
  EXPECT_NEAR(of_model(40, 40), error * error, 1e-10);
  EXPECT_GT(of_model(40, 40), of_model(40, 30));
}

TEST(TrajectoryPrior, RefusesSizesThatDoNotBelongTogether) {
  TrajectoryEnsemble ensemble = scaled_members(1);
  EXPECT_THROW(prior_of(ensemble), std::invalid_argument);
  ensemble = scaled_members(4);
  ensemble.nominal.resize(3);
  EXPECT_THROW(prior_of(ensemble), std::invalid_argument);
  ensemble = scaled_members(4);
  ensemble.misfits = Eigen::MatrixXd::Zero(5, 3);
  EXPECT_THROW(prior_of(ensemble), std::invalid_argument);
}

TEST(RandomWalkAboutANominalRun, KeepsTheLastDifferenceAndItsBandGrowsWithTheWay) {
  const TrajectoryPrior p = random_walk_about(times(), nominal(), 0.25);
  const double whole = nominal()(40);
  EXPECT_NEAR(std::sqrt(p.covariance(40, 40)), 0.25 * whole, 1e-12);
  EXPECT_EQ(p.covariance(0, 0), 0.0);
  EXPECT_TRUE(std::is_sorted(p.covariance.diagonal().begin(), p.covariance.diagonal().end()));

  // A reading without noise: its difference stays, and only the way from there on is uncertain.
  TrajectoryForecast forecast(p, {.noise = 0.0, .zero = 0.0});
  forecast.learn(p.time(10), p.nominal(10) + 3.0);
  for (const int later : {10, 20, 40}) {
    EXPECT_NEAR(forecast.at(p.time(later)).value, p.nominal(later) + 3.0, 1e-9);
    const double way = p.covariance(later, later) - p.covariance(10, 10);
    EXPECT_NEAR(forecast.at(p.time(later)).deviation, std::sqrt(way), 1e-6);
  }
  EXPECT_THROW(random_walk_about(times(), nominal().head(3), 0.25), std::invalid_argument);
}

/// Truths that are the nominal run times a factor, and begin earlier or later.
TEST(RandomWalkAboutANominalRun, BandsHoldWhereTheTruthIsAnotherCasting) {
  std::mt19937_64 random(7);
  const TrajectoryPrior p = random_walk_about(times(), nominal(), 0.25);
  int held = 0, asked = 0, last_held = 0;
  constexpr int castings = 400;
  for (int casting = 0; casting < castings; ++casting) {
    const double factor = 1.0 + 0.2 * normal(random), delay = 5.0 * normal(random);
    const Eigen::VectorXd moved = (times().array() - delay).max(0.0);
    const Eigen::VectorXd truth = factor * 30.0 * (1.0 - (-moved.array() / 60.0).exp());
    TrajectoryForecast forecast(p, gauge);
    for (int i = 0; i < 12; ++i) forecast.learn(p.time(i), truth(i) + gauge.noise * normal(random));
    const auto holds = [&](int at) {
      const Estimated there = forecast.at(p.time(at));
      return std::abs(truth(at) - there.value) < 1.645 * there.deviation;
    };
    for (const int at : {18, 24, 36}) {
      held += holds(at);
      ++asked;
    }
    last_held += holds(40);
  }
  std::printf("bands hold %.0f %%, at the end %.0f %%\n", 100.0 * held / asked,
              100.0 * last_held / castings);
  EXPECT_GT(held, 0.85 * asked);
  EXPECT_GT(last_held, 0.85 * castings);
}

}  // namespace
}  // namespace dccast::statistics
