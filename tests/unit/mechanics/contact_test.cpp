#include <gtest/gtest.h>

#include <numeric>

#include "tests/unit/mechanics/resting_block.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class ContactOf : public ::testing::Test {};
TYPED_TEST_SUITE(ContactOf, FreeFamilies);

int closed_of(const std::vector<char>& contact) {
  return std::accumulate(contact.begin(), contact.end(), 0);
}

TYPED_TEST(ContactOf, ConditionsAndBalanceHoldOnAPartialContact) {
  RestingBlock<TypeParam> block(1e-4);
  auto unknowns = block.at_rest();
  const auto outcome = solve_newton(block.body.problem, tight(1e-12), block.body.work, unknowns);
  ASSERT_TRUE(outcome.converged);

  const int closed = closed_of(unknowns.contact);
  EXPECT_GT(closed, 0);
  EXPECT_LT(closed, static_cast<int>(block.pairs())) << "the ends lift";

  const auto floor = block.floor(unknowns);
  EXPECT_NEAR(floor.total, block.body.problem.weight, 1e-8 * block.body.problem.weight);
  EXPECT_LE(
      mechanics::complementarity_error(floor.gap, floor.reaction, 1e-3, block.body.problem.weight),
      1e-8);
  for (std::size_t i = 0; i < block.pairs(); ++i) {
    EXPECT_EQ(unknowns.contact[i] != 0, std::abs(floor.gap[i]) < 1e-12) << i;
  }
}

/// The problem is convex: where the search starts must not matter.
TYPED_TEST(ContactOf, TheSetDoesNotDependOnItsStart) {
  for (double shrinkage : {-1e-4, 2e-5, 1e-4, 5e-4}) {
    RestingBlock<TypeParam> block(shrinkage);
    auto reference = block.at_rest();
    ASSERT_TRUE(
        solve_newton(block.body.problem, tight(1e-12), block.body.work, reference).converged);
    for (std::size_t only : {std::size_t(0), block.pairs() / 2, block.pairs() - 1}) {
      std::vector<char> nearly_open(block.pairs(), 0);
      nearly_open[only] = 1;
      auto unknowns = block.at_rest(nearly_open);
      ASSERT_TRUE(
          solve_newton(block.body.problem, tight(1e-12), block.body.work, unknowns).converged)
          << shrinkage << " from pair " << only;
      EXPECT_EQ(unknowns.contact, reference.contact) << shrinkage << " from pair " << only;
      for (std::size_t i = 0; i < reference.displacement.size(); ++i) {
        EXPECT_NEAR(unknowns.displacement[i], reference.displacement[i], 1e-12);
      }
    }
  }
}

/// On a floor that is lower everywhere by the same depth a block is the same block, lower.
TYPED_TEST(ContactOf, ALowerFloorLowersTheBlock) {
  constexpr double depth = 3e-3;
  RestingBlock<TypeParam> block(1e-4), lower(1e-4);
  lower.shape_floor([](double) { return depth; });
  auto reference = block.at_rest();
  auto unknowns = reference;
  ASSERT_TRUE(solve_newton(block.body.problem, tight(1e-12), block.body.work, reference).converged);
  ASSERT_TRUE(solve_newton(lower.body.problem, tight(1e-12), lower.body.work, unknowns).converged);
  EXPECT_EQ(unknowns.contact, reference.contact);
  for (std::size_t i = 0; i < reference.displacement.size(); ++i) {
    const bool vertical = i % TypeParam::dimension + 1 == TypeParam::dimension;
    const double down = vertical ? depth : 0.0;
    EXPECT_NEAR(unknowns.displacement[i], reference.displacement[i] - down, 1e-12) << i;
  }
}

/// A floor that is not flat: the gap is the displacement and the initial gap together, and what
/// bulges carries.
TYPED_TEST(ContactOf, ConditionsAndBalanceHoldOnACurvedFloor) {
  for (double slope : {-3e-3, 3e-3}) {
    RestingBlock<TypeParam> block(0.0);
    block.shape_floor([slope](double x) { return slope * x * x; });
    auto unknowns = block.at_rest();
    ASSERT_TRUE(solve_newton(block.body.problem, tight(1e-12), block.body.work, unknowns).converged)
        << slope;
    const auto floor = block.floor(unknowns);
    EXPECT_GT(closed_of(unknowns.contact), 0) << slope;
    EXPECT_NEAR(floor.total, block.body.problem.weight, 1e-8 * block.body.problem.weight) << slope;
    EXPECT_LE(mechanics::complementarity_error(floor.gap, floor.reaction, 1e-3,
                                               block.body.problem.weight),
              1e-8)
        << slope;
    const auto [middle, end] = block.ends();
    EXPECT_EQ(unknowns.contact[middle] != 0, slope > 0.0) << slope;
    EXPECT_EQ(unknowns.contact[end] != 0, slope < 0.0) << slope;
  }
}

TYPED_TEST(ContactOf, ABlockThatDoesNotBendStandsOnAllOfItsBottom) {
  RestingBlock<TypeParam> block(0.0);
  auto unknowns = block.at_rest();
  ASSERT_TRUE(solve_newton(block.body.problem, tight(1e-12), block.body.work, unknowns).converged);
  EXPECT_EQ(closed_of(unknowns.contact), static_cast<int>(block.pairs()));
  for (double r : block.floor(unknowns).reaction) EXPECT_GT(r, 0.0);
}

}  // namespace
}  // namespace dccast::mechanics
