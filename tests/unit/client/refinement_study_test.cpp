#include "client/refinement_study.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dccast::client {
namespace {

/// limit + c h^p on three meshes of halved cells.
std::vector<double> sequence(double limit, double c, double order) {
  std::vector<double> figures;
  for (int k = 0; k < 3; ++k) figures.push_back(limit + c * std::pow(0.5, k * order));
  return figures;
}

TEST(RefinementStudy, FindsOrderAndLimitOfACleanSequence) {
  for (const double order : {0.5, 1.0, 1.5, 2.0}) {
    const Extrapolation e = extrapolate(sequence(5.2, -1.1, order));
    ASSERT_TRUE(e.order.has_value()) << order;
    EXPECT_NEAR(*e.order, order, 1e-12);
    EXPECT_NEAR(e.value, 5.2, 1e-12);
    EXPECT_NEAR(e.uncertainty, 1.25 * 1.1 * std::pow(0.25, order), 1e-12);
  }
}

TEST(RefinementStudy, DoesNotBelieveAnOrderAboveThatOfTheMethods) {
  const Extrapolation e = extrapolate(sequence(5.2, -1.1, 4.0));
  EXPECT_NEAR(*e.order, 4.0, 1e-12);
  const double last_difference = 1.1 * (std::pow(0.5, 4) - std::pow(0.5, 8));
  EXPECT_NEAR(e.uncertainty, 1.25 * last_difference / 3.0, 1e-12);
}

TEST(RefinementStudy, ASequenceThatSwingsHasNoLimit) {
  const Extrapolation e = extrapolate({4.0, 5.0, 4.7});
  EXPECT_FALSE(e.order.has_value());
  EXPECT_EQ(e.value, 4.7);
  EXPECT_EQ(e.uncertainty, 1.0);
}

TEST(RefinementStudy, ASequenceThatDriftsHasNoLimit) {
  const Extrapolation e = extrapolate({4.0, 4.1, 4.5});
  EXPECT_FALSE(e.order.has_value());
  EXPECT_NEAR(e.uncertainty, 0.4, 1e-12);
}

TEST(RefinementStudy, AFigureThatDoesNotChangeIsItsOwnLimit) {
  const Extrapolation e = extrapolate({0.0, 0.0, 0.0});
  EXPECT_EQ(e.value, 0.0);
  EXPECT_EQ(e.uncertainty, 0.0);
}

TEST(RefinementStudy, TwoFiguresGiveTheirDifferenceOnly) {
  const Extrapolation e = extrapolate({4.0, 4.5});
  EXPECT_FALSE(e.order.has_value());
  EXPECT_EQ(e.value, 4.5);
  EXPECT_EQ(e.uncertainty, 0.5);
}

}  // namespace
}  // namespace dccast::client
