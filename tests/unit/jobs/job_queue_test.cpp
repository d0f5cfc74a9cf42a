#include "server/jobs/job_queue.hpp"

#include <gtest/gtest.h>

#include "server/jobs/events.hpp"

namespace dccast::jobs {
namespace {

v1::Job job(const std::string& id, v1::Priority priority, std::int64_t created_ms) {
  v1::Job result;
  result.set_id(id);
  result.set_priority(priority);
  *result.mutable_create_time() = timestamp(created_ms);
  return result;
}

constexpr std::int64_t start = 1700000000000;

std::optional<std::string> take_first(JobQueue& queue) {
  const auto first = queue.front();
  if (first) queue.erase(*first);
  return first;
}

TEST(JobQueue, OrdersByPriorityThenAge) {
  JobQueue queue;
  queue.push(job("late", v1::NORMAL, start + 2));
  queue.push(job("low", v1::LOW, start));
  queue.push(job("early", v1::NORMAL, start + 1));
  queue.push(job("high", v1::HIGH, start + 3));
  EXPECT_EQ(queue.position("high"), 1);
  EXPECT_EQ(queue.position("low"), 4);
  EXPECT_EQ(queue.position("late"), 3);
  for (const char* next : {"high", "early", "late", "low"}) EXPECT_EQ(take_first(queue), next);
  EXPECT_EQ(queue.front(), std::nullopt);
}

TEST(JobQueue, ALowJobThatHasWaitedLongGoesFirst) {
  JobQueue queue;
  queue.push(job("low", v1::LOW, start));
  queue.push(job("just before", v1::HIGH, start + 2 * JobQueue::priority_bonus_ms - 1));
  queue.push(job("just after", v1::HIGH, start + 2 * JobQueue::priority_bonus_ms + 1));
  for (const char* next : {"just before", "low", "just after"}) EXPECT_EQ(take_first(queue), next);
}

TEST(JobQueue, HoldsAJobOnce) {
  JobQueue queue;
  queue.push(job("a", v1::NORMAL, start));
  queue.push(job("a", v1::NORMAL, start));
  EXPECT_EQ(queue.size(), 1u);
  queue.erase("a");
  queue.erase("a");
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_EQ(queue.position("a"), 0);
}

}  // namespace
}  // namespace dccast::jobs
