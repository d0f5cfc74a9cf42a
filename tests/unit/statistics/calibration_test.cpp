#include "core/statistics/calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {
namespace {

constexpr int readings = 20;
constexpr double noise = 0.5;

Eigen::VectorXd times() {
  return Eigen::VectorXd::LinSpaced(readings, 0.2, 4.0);
}

/// A lift that tends to 20 to 40, at a rate of 0.5 to 2.5; a third input does nothing.
Eigen::MatrixXd lift(const Eigen::MatrixXd& places) {
  Eigen::MatrixXd curves(places.rows(), readings);
  const Eigen::ArrayXd t = times();
  for (Eigen::Index i = 0; i < places.rows(); ++i)
    curves.row(i) = (20.0 + 20.0 * places(i, 0)) *
                    (1.0 - (-(0.5 + 2.0 * places(i, 1)) * t).exp()).matrix().transpose();
  return curves;
}

Readings measured(const Eigen::VectorXd& values) {
  return {times(), values, Eigen::MatrixXd::Zero(readings, readings), std::nullopt, 0};
}

Eigen::VectorXd noisy(const Eigen::VectorXd& values, std::mt19937_64& random) {
  return values.unaryExpr([&](double value) { return value + noise * normal(random); });
}

CalibrationDraws calibrated(
    const Readings& curve, double common_error = 0.0,
    const CurveModel& model = [](const Eigen::MatrixXd& places) {
      return std::vector<Eigen::MatrixXd>{lift(places)};
    }) {
  return calibrate(model, 3, {curve}, {{25.0, common_error}}, 1);
}

double share_below(Eigen::VectorXd values, double share) {
  std::sort(values.begin(), values.end());
  return quantile(values, share);
}

bool holds(const Eigen::VectorXd& draws, double truth) {
  return share_below(draws, 0.05) <= truth && truth <= share_below(draws, 0.95);
}

double width(const Eigen::VectorXd& draws) {
  return share_below(draws, 0.95) - share_below(draws, 0.05);
}

TEST(Calibration, IntervalsHoldHiddenValuesNineTimesOfTen) {
  constexpr int castings = 20;
  std::mt19937_64 random(7);
  const auto hidden = [&] { return 0.1 + 0.8 * uniform(random); };
  int held = 0, noises = 0;
  for (int k = 0; k < castings; ++k) {
    const Eigen::MatrixXd truth =
        (Eigen::MatrixXd(1, 3) << hidden(), hidden(), hidden()).finished();
    const auto drawn = calibrated(measured(noisy(lift(truth).transpose(), random)));
    for (int input = 0; input < 2; ++input) held += holds(drawn.inputs.col(input), truth(0, input));
    noises += holds(drawn.noise.col(0), noise);
    EXPECT_LT(width(drawn.inputs.col(0)), 0.45);         // narrowed
    EXPECT_NEAR(width(drawn.inputs.col(2)), 0.9, 0.06);  // stays as it was
    EXPECT_GE(fixed_combinations(drawn.inputs), 2);
  }

  EXPECT_GE(held, 2 * castings * 8 / 10);
  EXPECT_GE(noises, castings * 8 / 10);
}

/// The misfit is surely more than the noise.
bool is_found_out(const CalibrationDraws& drawn) {
  return share_below(drawn.misfit.col(0), 0.05) > share_below(drawn.noise.col(0), 0.5);
}

/// A model without the bump that the casting has must not become certain of wrong values.
TEST(Calibration, FindsAWrongModelOut) {
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Constant(1, 3, 0.5);
  const Eigen::VectorXd bump = (4.0 * (-((times().array() - 1.5) / 0.6).square()).exp()).matrix();
  for (const unsigned seed : {3u, 4u, 5u, 6u}) {
    std::mt19937_64 random(seed);
    const Eigen::VectorXd right = noisy(lift(truth).transpose(), random);
    const auto of_right = calibrated(measured(right));
    const auto of_wrong = calibrated(measured(right + bump));
    EXPECT_FALSE(is_found_out(of_right)) << seed;
    EXPECT_TRUE(is_found_out(of_wrong)) << seed;
    EXPECT_GT(width(of_wrong.inputs.col(1)), 1.2 * width(of_right.inputs.col(1))) << seed;
    for (int input = 0; input < 2; ++input)
      EXPECT_TRUE(holds(of_wrong.inputs.col(input), 0.5)) << seed << input;
  }
}

TEST(Calibration, AnErrorOfAllComputedValuesWidensWhatItResembles) {
  std::mt19937_64 random(5);
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Constant(1, 3, 0.5);
  const Readings curve = measured(noisy(lift(truth).transpose(), random));
  const auto exact = calibrated(curve), meshed = calibrated(curve, 0.12);
  EXPECT_GT(width(meshed.inputs.col(0)), 2.0 * width(exact.inputs.col(0)));  // the height
  EXPECT_LT(width(meshed.inputs.col(1)), 1.5 * width(exact.inputs.col(1)));  // not the rate
  EXPECT_EQ(exact.common.norm(), 0.0);
  EXPECT_LT(correlations(
                (Eigen::MatrixXd(1000, 2) << meshed.inputs.col(0), meshed.common).finished())(0, 1),
            -0.8);
}

TEST(Calibration, TakesTheErrorOfTheModelForWhatItIs) {
  std::mt19937_64 random(5);
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Constant(1, 3, 0.5);
  Readings curve = measured(noisy(lift(truth).transpose(), random));
  curve.noise = noise;
  const auto exact = calibrated(curve);
  curve.model_covariance = Eigen::MatrixXd::Constant(readings, readings, 9.0);
  EXPECT_GT(width(calibrated(curve).inputs.col(0)), 1.3 * width(exact.inputs.col(0)));
}

/// Two inputs of which readings know the product alone.
TEST(Calibration, ShowsWhatCannotBeSeparated) {
  const CurveModel product = [](const Eigen::MatrixXd& places) {
    const Eigen::VectorXd height = ((1.0 + places.col(0).array()) * (1.0 + places.col(1).array()));
    return std::vector<Eigen::MatrixXd>{10.0 * height *
                                        (1.0 - (-times().array()).exp()).matrix().transpose()};
  };
  std::mt19937_64 random(5);
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Constant(1, 3, 0.5);
  Readings curve = measured(noisy(product(truth).front().row(0).transpose(), random));
  curve.noise = noise;
  const auto drawn = calibrated(curve, 0.0, product);

  EXPECT_LT(correlations(drawn.inputs)(0, 1), -0.7);
  EXPECT_NEAR(correlations(drawn.inputs)(0, 2), 0.0, 0.15);
  EXPECT_EQ(fixed_combinations(drawn.inputs.leftCols(2)), 1);

  const auto ridge = draws_along_ridge(drawn.inputs.leftCols(2), {0.05, 0.95});
  EXPECT_GT(std::abs(drawn.inputs(ridge[0], 0) - drawn.inputs(ridge[1], 0)), 0.5);

  const Eigen::Index central = central_draw(drawn.inputs);
  for (int input = 0; input < 3; ++input) EXPECT_NEAR(drawn.inputs(central, input), 0.5, 0.2);
}

}  // namespace
}  // namespace dccast::statistics
