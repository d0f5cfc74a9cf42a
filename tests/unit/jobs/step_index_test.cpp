#include "server/jobs/logs/step_index.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

constexpr std::size_t any_number = 1000000;
constexpr std::size_t any_bytes = 1u << 30;

class StepIndexTest : public testing::Test {
protected:
  void steps(int first, int last) {
    for (int step = first; step <= last; ++step) {
      v1::JobEvent event;
      event.mutable_step()->set_step(step);
      event.mutable_step()->set_time_s(++taken_);  // tells two versions of a step apart
      log_.append(event);
    }
  }
  void resumed(int step) {
    v1::JobEvent event;
    event.mutable_resumed()->set_step(step);
    log_.append(event);
  }
  void message() {
    v1::JobEvent event;
    event.mutable_message()->set_text("a word in between");
    log_.append(event);
  }
  static std::vector<int> numbers(const StepPage& page) {
    std::vector<int> numbers;
    for (const auto& step : page.steps) numbers.push_back(static_cast<int>(step.step()));
    return numbers;
  }
  std::optional<StepPage> page(const StepPlace& after = {}, std::size_t most = any_number,
                               std::size_t bytes = any_bytes) {
    return index_.page(log_, after, most, bytes);
  }
  static std::vector<int> from_to(int first, int last) {
    std::vector<int> numbers(static_cast<std::size_t>(last - first + 1));
    std::iota(numbers.begin(), numbers.end(), first);
    return numbers;
  }

  TemporaryFolder folder_;
  EventLog log_{folder_.path() / "events.log"};
  StepIndex index_;
  double taken_ = 0.0;
};

TEST_F(StepIndexTest, CountsStepsTakenTwiceOnce) {
  steps(1, 7);
  message();
  resumed(5);
  steps(6, 9);
  const auto all = page();
  ASSERT_TRUE(all);
  EXPECT_EQ(numbers(*all), from_to(1, 9));
  EXPECT_EQ(all->steps[5].time_s(), 8);  // the second version of step 6
  EXPECT_FALSE(all->next);
}

TEST_F(StepIndexTest, BeginsAnewWithTheRun) {
  steps(1, 7);
  steps(1, 2);  // begun again without a checkpoint
  EXPECT_EQ(numbers(*page()), from_to(1, 2));
  resumed(0);
  EXPECT_TRUE(page()->steps.empty());
}

TEST_F(StepIndexTest, PagesTogetherAreTheHistory) {
  steps(1, 100);
  resumed(60);
  message();
  steps(61, 90);
  resumed(30);
  steps(31, 150);
  std::vector<int> seen;
  std::optional<StepPlace> place = StepPlace{};
  while (place) {
    const auto one = page(*place, 7);
    ASSERT_TRUE(one);
    EXPECT_LE(one->steps.size(), 7u);
    for (const int step : numbers(*one)) seen.push_back(step);
    place = one->next;
  }
  EXPECT_EQ(seen, from_to(1, 150));
}

TEST_F(StepIndexTest, APageHoldsSomeBytesAndAtLeastOneStep) {
  steps(1, 50);
  const auto some = page({}, any_number, 200);
  EXPECT_GT(some->steps.size(), 1u);
  EXPECT_LT(some->steps.size(), 20u);
  ASSERT_TRUE(some->next);
  EXPECT_EQ(page({}, any_number, 1)->steps.size(), 1u);
}

TEST_F(StepIndexTest, APlaceStaysRightWhileTheLogGrows) {
  steps(1, 10);
  const auto first = page({}, 6);
  ASSERT_TRUE(first->next);
  steps(11, 12);
  resumed(8);  // after the place: nothing that was given is taken back
  steps(9, 20);
  EXPECT_EQ(numbers(*page(*first->next)), from_to(7, 20));
}

TEST_F(StepIndexTest, APlaceThatWasTakenBackIsNone) {
  steps(1, 10);
  const auto first = page({}, 6);
  resumed(5);
  EXPECT_FALSE(page(*first->next));
  steps(6, 30);
  EXPECT_FALSE(page(*first->next));
  EXPECT_FALSE(page({1000000, 3}));
}

TEST(StepIndexes, KeepsThoseAskedForLast) {
  StepIndexes indexes;
  const auto first = indexes.of("a");
  for (int i = 0; i < 15; ++i) indexes.of(std::to_string(i));
  EXPECT_EQ(indexes.of("a"), first);
  for (int i = 0; i < 16; ++i) indexes.of(std::to_string(i));
  EXPECT_NE(indexes.of("a"), first);
}

}  // namespace
}  // namespace dccast::jobs
