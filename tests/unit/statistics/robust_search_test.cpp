#include "core/statistics/robust_search.hpp"
#include "core/statistics/sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace dccast::statistics {
namespace {

/// A value of one design input and one datum: x + 0.2 (xi - 0.5), wanted within 0.4 to 0.6. At the
/// distance d of x from 0.5 the share 5 d of the data leads out of the band, all beyond 0.2. A
/// second input below 0.5 is a danger to four in five data. Small x costs more.
constexpr double per_distance = 5.0;

double value_of(double x, double datum) {
  return x + 0.2 * (datum - 0.5);
}

bool in_danger(double second, double datum) {
  return second < 0.5 && datum > 0.2;
}

Outcomes known(const Eigen::MatrixXd& places) {
  Outcomes outcomes{places.col(0) + 0.2 * (places.col(2).array() - 0.5).matrix(),
                    Eigen::VectorXd(places.rows()), 0.0};
  for (Eigen::Index i = 0; i < places.rows(); ++i)
    outcomes.danger(i) = in_danger(places(i, 1), places(i, 2)) ? 1.0 : 0.0;
  return outcomes;
}

DesignProblem problem() {
  return {.design_inputs = 2,
          .least = 0.4,
          .greatest = 0.6,
          .outcomes = known,
          .cost = [](const Eigen::RowVectorXd& design) { return 1.0 - design(0); },
          .permitted = [](Eigen::RowVectorXd design) { return design; }};
}

TEST(Classifier, SharesAreThoseOfTheTruth) {
  const Eigen::MatrixXd places = hypercube(120, 3, 1);
  std::vector<bool> yes;
  for (Eigen::Index i = 0; i < places.rows(); ++i) yes.push_back(places(i, 0) > places(i, 1));
  const Classifier classifier(places, yes);
  EXPECT_LT(classifier.misjudged(), 0.12);
  Eigen::MatrixXd over = hypercube(400, 3, 2);
  for (const double first : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    over.col(0).setConstant(first);
    EXPECT_NEAR(classifier.probability(over).mean(), first, 0.07);
  }
}

TEST(Classifier, AnswersThatAreAllAlikeLeaveAChanceOfTheOther) {
  const Classifier never(hypercube(18, 2, 1), std::vector<bool>(18, false));
  EXPECT_NEAR(never.probability(hypercube(3, 2, 2)).maxCoeff(), 0.05, 1e-12);
  const Classifier always(hypercube(18, 2, 1), std::vector<bool>(18, true));
  EXPECT_NEAR(always.probability(hypercube(3, 2, 2)).minCoeff(), 0.95, 1e-12);
  EXPECT_EQ(never.misjudged(), 0.0);
}

TEST(RobustSearch, ScoresAreTheKnownShares) {
  const Eigen::MatrixXd data = hypercube(2000, 1, 3);
  for (const double x : {0.35, 0.5, 0.58}) {
    const DesignScore safe = score_design(problem(), Eigen::RowVector2d(x, 0.9), data);
    const double away = std::abs(x - 0.5);
    EXPECT_NEAR(safe.risk, per_distance * away, 2e-3);
    EXPECT_NEAR(safe.median, x, 1e-3);
    EXPECT_NEAR(safe.low, x - 0.09, 1e-3);
    EXPECT_NEAR(safe.high, x + 0.09, 1e-3);
    EXPECT_NEAR(safe.distance, away, 1e-3);
    EXPECT_EQ(safe.danger, 0.0);
  }
  const DesignScore risky = score_design(problem(), Eigen::RowVector2d(0.5, 0.1), data);
  EXPECT_NEAR(risky.danger, 0.8, 1e-3);
  EXPECT_NEAR(risky.risk, 0.8, 1e-3);
  EXPECT_EQ(risky.cost, 0.5);
}

TEST(RobustSearch, AnErrorOfTheValueIsARisk) {
  DesignProblem uncertain = problem();
  uncertain.outcomes = [](const Eigen::MatrixXd& places) {
    Outcomes outcomes = known(places);
    outcomes.value.setConstant(0.5);
    outcomes.error = 0.1;
    return outcomes;
  };
  const DesignScore score =
      score_design(uncertain, Eigen::RowVector2d(0.5, 0.9), hypercube(10, 1, 3));
  EXPECT_NEAR(score.risk, 0.3173, 1e-4);  // beyond one standard deviation
  EXPECT_NEAR(score.high, 0.5 + 0.16449, 1e-4);
}

TEST(RobustSearch, TheFrontIsTheKnownOne) {
  const auto front = pareto_front(problem(), hypercube(256, 1, 1), 1);
  ASSERT_GT(front.size(), 10U);
  EXPECT_LT(front.front().score.risk, 0.03);
  EXPECT_NEAR(front.front().design(0), 0.5, 0.01);
  for (const ScoredDesign& one : front) {
    EXPECT_GT(one.design(0), 0.49) << "the mirrored design costs less";
    if (one.score.danger == 0.0) {
      EXPECT_NEAR(one.score.risk, std::min(1.0, per_distance * one.score.distance), 0.02);
    }
    for (const ScoredDesign& other : front) EXPECT_FALSE(dominates(other.score, one.score));
  }
  EXPECT_TRUE(std::ranges::is_sorted(front, {}, [](const auto& one) { return one.score.risk; }));

  const auto again = pareto_front(problem(), hypercube(256, 1, 1), 1);
  ASSERT_EQ(again.size(), front.size());

  for (std::size_t i = 0; i < front.size(); ++i) EXPECT_EQ(again[i].design, front[i].design);
}

TEST(RobustSearch, LimitsHold) {
  DesignProblem limited = problem();
  limited.permitted = [](Eigen::RowVectorXd design) {
    design(0) = std::min(design(0), 0.45);
    return design;
  };
  for (const ScoredDesign& one : pareto_front(limited, hypercube(64, 1, 1), 1))
    EXPECT_LE(one.design(0), 0.45);
}

TEST(RobustSearch, SomeOfAFrontBeginWithTheLeastRiskAndReachItsEnds) {
  const auto front = pareto_front(problem(), hypercube(64, 1, 1), 1);
  const auto some = spread_over(front, 4, 0.5);
  ASSERT_EQ(some.size(), 4U);
  EXPECT_EQ(some.front().design, front.front().design);
  for (const ScoredDesign& one : some) EXPECT_LE(one.score.risk, front.front().score.risk + 0.5);
  EXPECT_GT(some.back().score.risk, front.front().score.risk + 0.4);
  EXPECT_EQ(spread_over(front, 10000, 1.0).size(), front.size());
}

TEST(RobustSearch, AWrongModelIsCorrectedOnTheMeanAndTheErrorCoversTheTruth) {
  constexpr double truth = 0.3, modelled = 0.1;
  constexpr int repeats = 400;
  std::mt19937_64 random(5);
  double mean = 0.0;
  int covered = 0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::vector<bool> lost;
    for (int i = 0; i < 40; ++i)
      lost.push_back(static_cast<double>(random() >> 11) * 0x1p-53 < truth);
    const Share share = corrected_share(modelled, Eigen::VectorXd::Constant(40, modelled), lost);
    mean += share.value / repeats;
    covered += std::abs(share.value - truth) <= 2.0 * share.error ? 1 : 0;
  }

  EXPECT_NEAR(mean, truth, 0.015);
  EXPECT_GT(covered, 0.9 * repeats);
  EXPECT_EQ(corrected_share(0.25, {}, {}).value, 0.25);
  EXPECT_GT(corrected_share(0.0, Eigen::VectorXd::Zero(10), std::vector<bool>(10, false)).error,
            0.05)
      << "ten good ones do not make certain";
}

/// From runs to the share: what surfaces make of them has to find the known figure.
TEST(RobustSearch, SurfacesOfRunsFindTheKnownShare) {
  const Eigen::MatrixXd runs = hypercube(80, 3, 7);
  Eigen::VectorXd values(runs.rows());
  std::vector<bool> dangers;
  for (Eigen::Index i = 0; i < runs.rows(); ++i) {
    values(i) = value_of(runs(i, 0), runs(i, 2));
    dangers.push_back(in_danger(runs(i, 1), runs(i, 2)));
  }
  const GaussianProcess value(runs, values);
  const Classifier danger(runs, dangers);
  DesignProblem surfaces = problem();
  surfaces.outcomes = [&](const Eigen::MatrixXd& places) {
    return Outcomes{value.means(places), danger.probability(places),
                    value.left_out_errors().norm() / std::sqrt(80.0)};
  };
  const ScoredDesign best = pareto_front(surfaces, hypercube(64, 1, 1), 1).front();

  EXPECT_GT(best.design(1), 0.5);
  EXPECT_NEAR(best.design(0), 0.5, 0.03);

  // At a design that is not safe, with some castings that are looked at.
  const Eigen::RowVector2d design(0.56, 0.9);
  const Eigen::MatrixXd looked_at = hypercube(16, 1, 9);
  Eigen::MatrixXd places(16, 3);
  places << design.replicate(16, 1), looked_at;
  std::vector<bool> lost;
  for (Eigen::Index i = 0; i < 16; ++i) lost.push_back(value_of(design(0), looked_at(i, 0)) > 0.6);
  const Share share = corrected_share(score_design(surfaces, design, hypercube(256, 1, 3)).risk,
                                      risk_at(surfaces, places), lost);
  EXPECT_NEAR(share.value, 0.3, 2.0 * share.error);
  EXPECT_LT(share.error, 0.12);
}

}  // namespace
}  // namespace dccast::statistics
