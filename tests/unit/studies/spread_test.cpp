#include "server/studies/curl_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dccast::studies {
namespace {

/// 20 + t (6 x + 2 y) mm at t = 1 and 2; a third input does nothing.
SampledCurls linear(double error_m) {
  SampledCurls sampled;
  sampled.curls = [](const Eigen::MatrixXd& places) {
    Eigen::MatrixXd curls(places.rows(), 2);
    for (int t = 0; t < 2; ++t)
      curls.col(t) =
          (1e-3 * (20.0 + (t + 1) * (6.0 * places.col(0) + 2.0 * places.col(1)).array())).matrix();
    return curls;
  };
  sampled.time_s = {1.0, 2.0};
  sampled.cast_length_m = {0.01, 0.02};
  sampled.error_m = {error_m, error_m};
  return sampled;
}

TEST(Spread, HasTheQuantilesAndSharesOfALinearFunction) {
  const v1::Spread spread = spread_of(linear(0.0), 3, CurlBand{0.0, 28e-3});
  ASSERT_EQ(spread.time_s_size(), 2);
  EXPECT_NEAR(spread.median_m(0), 24e-3, 0.1e-3);
  EXPECT_NEAR(spread.median_m(1), 28e-3, 0.1e-3);

  // The 5 % quantile q of 6 x + 2 y has q^2 / (2 6 2) = 0.05.
  const double low = std::sqrt(0.05 * 24.0);
  EXPECT_NEAR(spread.low_m(0), (20.0 + low) * 1e-3, 0.1e-3);
  EXPECT_NEAR(spread.high_m(1), (20.0 + 2.0 * (8.0 - low)) * 1e-3, 0.1e-3);
  EXPECT_NEAR(spread.inside_band(), 0.5, 0.02);
  ASSERT_EQ(spread.shares_size(), 4);
  EXPECT_EQ(spread.shares(3).total(1), 0.0);
  EXPECT_NEAR(spread.shares(0).first(1), 0.9, 0.05);
  EXPECT_NEAR(spread.shares(1).total(1), 0.1, 0.02);
  EXPECT_NEAR(spread.shares(2).total(1), 0.0, 1e-12);
}

TEST(Spread, HoldsTheErrorOfItsFunction) {
  const v1::Spread exact = spread_of(linear(0.0), 3, std::nullopt);
  const v1::Spread rough = spread_of(linear(10e-3), 3, std::nullopt);
  EXPECT_FALSE(exact.has_inside_band());
  const double width = rough.high_m(0) - rough.low_m(0);
  EXPECT_GT(width, 3.2 * 10e-3);  // 3.29 standard deviations, and the inputs
  EXPECT_LT(width, 3.5 * 10e-3);
  const double of_inputs = (36.0 + 4.0) / 12.0;  // mm2, of 6 x + 2 y
  EXPECT_NEAR(rough.shares(3).total(0), 100.0 / (100.0 + of_inputs), 1e-3);
  EXPECT_NEAR(rough.shares(0).total(0), 0.9 * of_inputs / (100.0 + of_inputs), 2e-3);
}

TEST(Spread, IsTheSameEachTime) {
  EXPECT_EQ(spread_of(linear(1e-3), 3, std::nullopt).SerializeAsString(),
            spread_of(linear(1e-3), 3, std::nullopt).SerializeAsString());
}

}  // namespace
}  // namespace dccast::studies
