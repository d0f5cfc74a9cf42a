#include "core/statistics/line_posterior.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {
namespace {

constexpr double scatter = 0.2;

/// (place) the first datum as a standard normal number, plus a constant.
LineSurface first_datum(double constant, double error = 0.0) {
  return {[=](const Eigen::MatrixXd& places) {
            return Eigen::VectorXd(places.col(0).unaryExpr(&normal_quantile).array() + constant);
          },
          error};
}

/// A danger where the first of two data exceeds a limit, in half of all castings.
LineModel step_danger() {
  return {.inputs = 2, .dangers = {first_datum(0.0)}, .curl = {}, .scatter = scatter};
}

LineRecord record(bool danger, double count = 1.0) {
  return {.dangers = {danger}, .count = count};
}

/// The share of danger after so many castings, by integration over the plant's part of the datum.
/// A record of n castings says nothing with a probability of 0.01 / n, of a bleed-out 0.001.
double exact_share(double sound, double bled_out) {
  double share = 0.0, all = 0.0, sound_alone = 0.0, prior = 0.0;
  const auto integrate = [&](auto&& take) {
    for (double plant = -8.0; plant <= 8.0; plant += 0.005) {
      const double danger = normal_below(std::sqrt((1.0 - scatter) / scatter) * plant);
      take(danger, std::exp(-0.5 * plant * plant));
    }
  };
  integrate([&](double danger, double weight) {
    prior += weight;
    sound_alone += weight * std::pow(1.0 - danger, sound);
  });
  integrate([&](double danger, double weight) {
    const double wrong = 0.01 / std::max(1.0, sound);
    weight *= (1.0 - wrong) * std::pow(1.0 - danger, sound) + wrong * sound_alone / prior;
    if (bled_out > 0.0) weight *= 0.999 * std::pow(danger, bled_out) + 0.001 * 0.5;
    share += weight * danger;
    all += weight;
  });
  return share / all;
}

TEST(LinePosterior, SoundCastingsLowerTheDangerAsTheyShould) {
  double before = 1.0;
  for (const double count : {0.0, 1.0, 5.0, 30.0, 200.0}) {
    std::vector<LineRecord> records;
    if (count > 0.0) records.push_back(record(false, count));
    const auto found = next_casting(step_danger(), records, 1);
    EXPECT_NEAR(found.danger, exact_share(count, 0.0), 0.004 + 0.15 * exact_share(count, 0.0))
        << count;
    EXPECT_LT(found.danger, before);
    EXPECT_LE(found.danger_low, found.danger_high);
    EXPECT_GT(found.effective_draws, 100.0);
    before = found.danger;
  }
  // Equal castings differ little: they are no independent proofs that nothing can happen.
  EXPECT_GT(before, 0.0005);
}

TEST(LinePosterior, OneBleedOutRaisesTheDanger) {
  const auto sound = next_casting(step_danger(), {record(false, 30.0)}, 1);
  const auto bled = next_casting(step_danger(), {record(false, 30.0), record(true)}, 1);
  EXPECT_GT(bled.danger, 1.5 * sound.danger);
  EXPECT_NEAR(bled.danger, exact_share(30.0, 1.0), 0.2 * exact_share(30.0, 1.0));
}

/// Single records and one of many are the same castings, but each record may be wrong.
TEST(LinePosterior, EqualRecordsCountEach) {
  const std::vector<LineRecord> single(30, record(false));
  const auto many = next_casting(step_danger(), {record(false, 30.0)}, 1);
  const auto each = next_casting(step_danger(), single, 1);
  EXPECT_NEAR(each.danger, many.danger, 0.3 * many.danger);
  EXPECT_EQ(each.wrong.size(), 30);
}

TEST(LinePosterior, ADangerThatNoRecordKnowsStays) {
  LineModel model = step_danger();
  model.dangers.push_back({[](const Eigen::MatrixXd& places) {
                             return Eigen::VectorXd(
                                 places.col(1).unaryExpr(&normal_quantile).array() - 1.0);
                           },
                           0.0});
  const auto found = next_casting(model, {{.dangers = {false, std::nullopt}, .count = 200.0}}, 1);
  EXPECT_NEAR(found.danger, normal_below(-1.0), 0.04) << "of the second alone";
}

/// The error of the surface is one more thing that the castings of a plant tell of.
TEST(LinePosterior, AnErrorOfTheSurfaceIsLearnedToo) {
  LineModel model{.inputs = 1,
                  .dangers = {{[](const Eigen::MatrixXd& places) {
                                 return Eigen::VectorXd(Eigen::VectorXd::Constant(
                                     places.rows(), normal_quantile(0.83)));
                               },
                               1.0}},
                  .curl = {},
                  .scatter = scatter};
  EXPECT_NEAR(next_casting(model, {}, 1).danger, 0.83, 0.03);
  const auto found = next_casting(model, {record(false, 200.0)}, 1);
  EXPECT_LT(found.danger, 0.05);
  EXPECT_GT(found.danger, 0.0);
}

/// Of a linear curl and normal noise all is known.
TEST(LinePosterior, CurlsConditionTheNextOne) {
  LineModel model{.inputs = 2, .dangers = {}, .curl = first_datum(40.0), .scatter = scatter};
  const double noise = 0.5, kept = 1.0 - scatter, own = scatter + noise * noise;
  const std::vector<double> curls{41.2, 40.8, 41.5, 40.9, 41.1};
  std::vector<LineRecord> records;
  double sum = 0.0;
  for (const double curl : curls) {
    records.push_back({.dangers = {}, .count = 1.0, .curl = curl, .curl_noise = noise});
    sum += (curl - 40.0) / own;
  }

  const double plant = 1.0 / (1.0 / kept + 5.0 / own);
  const double deviation = std::sqrt(plant + scatter);
  const auto found = next_casting(model, records, 3);
  EXPECT_NEAR(found.curl_median, 40.0 + plant * sum, 0.1);
  EXPECT_NEAR(found.curl_high - found.curl_low, 2 * 1.645 * deviation, 0.15 * deviation * 3.29);
  EXPECT_NEAR(found.told(0), plant / (plant + scatter), 0.1) << "the plant's part of the datum";
  EXPECT_LT(found.told(1), 0.02) << "the curl does not depend on it";

  const auto before = next_casting(model, {}, 3);
  EXPECT_NEAR(before.curl_high - before.curl_low, 2 * 1.645, 0.2);
}

/// A curl that is linear in data that are uniform bends between the plant's part of the data and
/// the mean of its castings, and these scatter more than the bent line says.
TEST(LinePosterior, TheBandHasTheScatterOfCastingsWhoseDataAreUniform) {
  const LineModel model{
      .inputs = 1,
      .dangers = {},
      .curl = {{[](const Eigen::MatrixXd& places) { return Eigen::VectorXd(10.0 * places.col(0)); },
                0.0}},
      .scatter = scatter};
  const std::vector<LineRecord> records(
      20, {.dangers = {}, .count = 1.0, .curl = 5.0, .curl_noise = 0.1});
  const auto found = next_casting(model, records, 3);

  // Variance of a uniform number, less that of its mean at a plant whose part is z: the correlation
  // of two castings of a plant is (1 - scatter), so that it is asin((1 - scatter) / 2) / 2 pi.
  const double own =
      100.0 * (1.0 / 12.0 - std::asin(0.5 * (1.0 - scatter)) / (2.0 * std::numbers::pi));
  const double plant = own / 20.0;
  EXPECT_NEAR(found.curl_high - found.curl_low, 3.29 * std::sqrt(own + plant), 0.4);
  EXPECT_EQ(found.castings.cols(), 1);
  EXPECT_NEAR(found.castings.mean(), 0.5, 0.03);
  // In the middle of its range a datum scatters more than on average.
  const double in_the_middle = std::asin(scatter / (1.0 + scatter)) / (2.0 * std::numbers::pi);
  EXPECT_NEAR((found.castings.array() - found.castings.mean()).square().mean(), in_the_middle,
              0.004);
}

TEST(LinePosterior, AWrongRecordIsKnownAndMovesNoBand) {
  LineModel model{.inputs = 2, .dangers = {}, .curl = first_datum(40.0), .scatter = scatter};
  std::vector<LineRecord> records(8,
                                  {.dangers = {}, .count = 1.0, .curl = 41.0, .curl_noise = 0.3});
  const auto right = next_casting(model, records, 3);
  records.push_back({.dangers = {}, .count = 1.0, .curl = 14.0, .curl_noise = 0.3});
  const auto found = next_casting(model, records, 3);
  EXPECT_GT(found.wrong(8), 0.9);
  EXPECT_LT(found.wrong(0), 0.1);
  EXPECT_NEAR(found.curl_low, right.curl_low, 0.15);
  EXPECT_NEAR(found.curl_high, right.curl_high, 0.15);

  // Sound, though this plant always bleeds.
  std::vector<LineRecord> castings(3000, record(true));
  castings.push_back(record(false));
  const auto bled = next_casting(step_danger(), castings, 1);
  EXPECT_GT(bled.wrong(3000), 0.5);
  EXPECT_LT(bled.wrong(0), 0.05);
}

}  // namespace
}  // namespace dccast::statistics
