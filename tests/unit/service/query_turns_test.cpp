#include "server/service/query_turns.hpp"

#include <gtest/gtest.h>

#include <future>
#include <optional>

namespace dccast::service {
namespace {

using jobs::Urgency;

/// Work that runs until it is let go.
class Blocker {
public:
  std::function<void()> work() {
    return [this] {
      begun_.set_value();
      go_.get_future().wait();
    };
  }
  void wait_for_begin() { begun_.get_future().wait(); }
  void let_go() { go_.set_value(); }

private:
  std::promise<void> begun_, go_;
};

TEST(QueryTurns, AQueryWaitsForThoseOfItsUrgencyAlone) {
  Blocker draft;
  std::promise<void> quick_ran;
  std::optional<QueryWait> wait;
  const auto note = [&](const QueryWait& of_query) { wait = of_query; };
  QueryTurns turns(1, {});

  EXPECT_TRUE(turns.post(Urgency::draft, 10.0, note, draft.work(), 0));
  draft.wait_for_begin();
  EXPECT_TRUE(turns.post(
      Urgency::quick, 1.0, note, [&] { quick_ran.set_value(); }, 0));
  quick_ran.get_future().wait();
  EXPECT_FALSE(wait);

  EXPECT_TRUE(turns.post(
      Urgency::draft, 4.0, note, [] {}, 0));
  EXPECT_EQ(wait.value().running, 1);
  EXPECT_EQ(wait->ahead, 0);
  EXPECT_NEAR(wait->expected_s, 10.0, 1.0);

  EXPECT_TRUE(turns.post(
      Urgency::draft, 4.0, note, [] {}, 0));
  EXPECT_EQ(wait->ahead, 1);
  EXPECT_NEAR(wait->expected_s, 14.0, 1.0);
  draft.let_go();
}

TEST(QueryTurns, TooManyAreRefusedAndDoNotCountAfterwards) {
  Blocker running;
  QueryWait wait;
  const auto note = [&](const QueryWait& of_query) { wait = of_query; };
  QueryTurns turns(1, {.number = 1});

  EXPECT_TRUE(turns.post(Urgency::quick, 1.0, note, running.work(), 0));
  running.wait_for_begin();
  EXPECT_TRUE(turns.post(
      Urgency::quick, 1.0, note, [] {}, 0));
  EXPECT_FALSE(turns.post(
      Urgency::quick, 1.0, note, [] {}, 0));
  EXPECT_FALSE(turns.post(
      Urgency::quick, 1.0, note, [] {}, 0));
  EXPECT_EQ(wait.ahead, 1);
  running.let_go();
}

}  // namespace
}  // namespace dccast::service
