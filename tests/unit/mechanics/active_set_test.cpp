#include "core/mechanics/step_constraints.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace dccast::mechanics {
namespace {

using ::testing::ElementsAre;

constexpr ActiveSet::Tolerance tolerance{1e-10, 1e-3};

TEST(ActiveSet, ClosesWhatPenetratesAndOpensWhatPulls) {
  ActiveSet set({1, 1, 0, 0});
  const std::vector<double> gap{0.0, 0.0, -1e-5, 1e-5}, reaction{10.0, -2.0, 0.0, 0.0};
  EXPECT_EQ(set.update(gap, reaction, tolerance, false), 2);
  EXPECT_THAT(set.active(), ElementsAre(1, 0, 1, 0));
}

TEST(ActiveSet, StaysWithinTheTolerances) {
  ActiveSet set({1, 0});
  EXPECT_EQ(set.update(std::vector{0.0, -0.9e-10}, std::vector{-0.9e-3, 0.0}, tolerance, false), 0);
  EXPECT_THAT(set.active(), ElementsAre(1, 0));
  EXPECT_EQ(set.update(std::vector{0.0, -1.1e-10}, std::vector{1.0, 0.0}, tolerance, false), 1);
  EXPECT_THAT(set.active(), ElementsAre(1, 1));
}

TEST(ActiveSet, TheReactionOfAnOpenPairAndTheGapOfAClosedOneSayNothing) {
  ActiveSet set({1, 0});
  EXPECT_EQ(set.update(std::vector{-1.0, 1.0}, std::vector{1.0, -1.0}, tolerance, false), 0);
}

/// The worst is the one furthest beyond its own tolerance, whichever side it is on.
TEST(ActiveSet, OneByOneMovesOnlyTheWorst) {
  ActiveSet set({1, 1, 0});
  const std::vector<double> gap{0.0, 0.0, -5e-9}, reaction{-20e-3, 7.0, 0.0};
  EXPECT_EQ(set.update(gap, reaction, tolerance, true), 1);
  EXPECT_THAT(set.active(), ElementsAre(1, 1, 1)) << "50 gap tolerances against 20 of force";
  EXPECT_EQ(set.update(gap, reaction, tolerance, true), 1);
  EXPECT_THAT(set.active(), ElementsAre(0, 1, 1));
}

TEST(ActiveSet, IsNeverEmptied) {
  ActiveSet set({1, 1, 1, 0});
  const std::vector<double> gap{0.0, 0.0, 0.0, 1.0}, reaction{-3.0, -1.0, -2.0, 0.0};
  EXPECT_EQ(set.update(gap, reaction, tolerance, false), 2);
  EXPECT_THAT(set.active(), ElementsAre(0, 1, 0, 0)) << "the one that pulls least stays";
  EXPECT_EQ(set.update(gap, reaction, tolerance, false), 0);
  EXPECT_EQ(set.update(gap, reaction, tolerance, true), 0);
  EXPECT_THAT(set.active(), ElementsAre(0, 1, 0, 0));
}

/// Two pairs that carry and one of a wall, which cannot carry: one that carries stays.
TEST(ActiveSet, AWallDoesNotCarry) {
  ActiveSet set({1, 1, 1}, 2);
  EXPECT_EQ(
      set.update(std::vector<double>{0, 0, 0}, std::vector<double>{-2, -1, 5}, tolerance, false),
      1);
  EXPECT_EQ(set.active(), (std::vector<char>{0, 1, 1}));
  ActiveSet walls({1, 1}, 0);
  EXPECT_EQ(walls.update(std::vector<double>{0, 0}, std::vector<double>{-2, -1}, tolerance, false),
            2);
  EXPECT_EQ(walls.active(), (std::vector<char>{0, 0}));
}

TEST(ActiveSet, AllMayLeaveWhenOthersComeIn) {
  ActiveSet set({1, 0});
  EXPECT_EQ(set.update(std::vector{0.0, -1e-6}, std::vector{-1.0, 0.0}, tolerance, false), 2);
  EXPECT_THAT(set.active(), ElementsAre(0, 1));
}

TEST(Complementarity, MeasuresPenetrationPullAndProduct) {
  const auto error = [](double gap, double reaction) {
    return complementarity_error(std::vector{gap}, std::vector{reaction}, 1e-3, 100.0);
  };
  EXPECT_EQ(error(0.0, 50.0), 0.0);
  EXPECT_EQ(error(5.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(error(-1e-4, 0.0), 0.1);
  EXPECT_DOUBLE_EQ(error(0.0, -20.0), 0.2);
  EXPECT_DOUBLE_EQ(error(1e-4, 50.0), 0.1);
  EXPECT_DOUBLE_EQ(error(1e-2, 30.0), 0.3);
}

TEST(Complementarity, IsThatOfTheWorstPair) {
  EXPECT_DOUBLE_EQ(
      complementarity_error(std::vector{0.0, -2e-3, 0.0}, std::vector{1.0, 0.0, -1.0}, 1e-3, 1.0),
      2.0);
  EXPECT_EQ(complementarity_error({}, {}, 1.0, 1.0), 0.0);
}

}  // namespace
}  // namespace dccast::mechanics
