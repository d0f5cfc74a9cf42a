#include "server/relay/turn_budget.hpp"

#include <gtest/gtest.h>

namespace dccast::relay {

namespace {

struct TurnBudgetTest : testing::Test {
  const TurnBudget::Clock::time_point now = TurnBudget::Clock::now();
  TurnBudget turn;
  void SetUp() override { turn.begin(now); }
};

TEST_F(TurnBudgetTest, BytesAreBounded) {
  turn.spend(TurnBudget::most_bytes - 1);
  EXPECT_FALSE(turn.is_spent(now));
  turn.spend(1);
  EXPECT_TRUE(turn.is_spent(now));
  turn.begin(now);
  EXPECT_FALSE(turn.is_spent(now));
}

TEST_F(TurnBudgetTest, TransfersAreBoundedHoweverFewBytesTheyMove) {
  for (std::size_t i = 0; i < TurnBudget::most_transfers; ++i) {
    EXPECT_FALSE(turn.is_spent(now));
    turn.spend(1);
  }
  EXPECT_TRUE(turn.is_spent(now));
}

TEST_F(TurnBudgetTest, TimeIsBoundedButNotTheFirstTransfer) {
  const auto late = now + TurnBudget::most_time;
  EXPECT_FALSE(turn.is_spent(late));
  turn.spend(1);
  EXPECT_FALSE(turn.is_spent(now));
  EXPECT_TRUE(turn.is_spent(late));
}

}  // namespace

}  // namespace dccast::relay
