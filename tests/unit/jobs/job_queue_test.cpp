#include "server/jobs/queue/job_queue.hpp"

#include <gtest/gtest.h>

#include "server/jobs/folder/events.hpp"

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

v1::Job job_of(const std::string& owner, const std::string& id, v1::Priority priority,
               std::int64_t created_ms) {
  v1::Job result = job(id, priority, created_ms);
  result.set_owner(owner);
  return result;
}

// Two owners of whom one has filled the queue first.
TEST(JobQueue, OwnersTakeTurnsAsTheyUseTheProcessors) {
  JobQueue queue;
  for (int i = 0; i < 4; ++i)
    queue.push(job_of("anna", "a" + std::to_string(i), v1::NORMAL, start + i));
  queue.push(job_of("ben", "b low", v1::LOW, start + 10));
  queue.push(job_of("ben", "b high", v1::HIGH, start + 11));

  EXPECT_EQ(queue.position("a0"), 2) << "priority is inside an owner's share, and between equals";
  EXPECT_EQ(queue.position("b low"), 3);
  EXPECT_EQ(queue.position("a3"), 6);

  const auto next = [&queue] {
    const auto id = take_first(queue).value();
    queue.charge(id.front() == 'a' ? "anna" : "ben", JobQueue::start_charge_s, start);
    return id;
  };
  for (const char* expected : {"b high", "a0", "a1", "b low", "a2", "a3"})
    EXPECT_EQ(next(), expected);
}

TEST(JobQueue, UseOfAWhileAgoCountsLess) {
  constexpr std::int64_t day_ms = 24 * 3600 * 1000;
  JobQueue queue;
  queue.push(job_of("anna", "a", v1::NORMAL, start));
  queue.push(job_of("ben", "b", v1::NORMAL, start + 1));
  queue.charge("anna", 1000.0, start);
  EXPECT_EQ(queue.front(), "b");
  queue.charge("ben", 600.0, start + day_ms);
  EXPECT_EQ(queue.front(), "a") << "1000 s of yesterday are 500 s";
  queue.charge("anna", 200.0, start + 2000 * day_ms);  // years later
  EXPECT_EQ(queue.front(), "b");
}

TEST(JobQueue, WithoutSharesThereIsOneOrder) {
  JobQueue queue(std::chrono::seconds(0));
  queue.push(job_of("anna", "a", v1::NORMAL, start));
  queue.push(job_of("ben", "b", v1::NORMAL, start + 1));
  queue.charge("anna", 1000.0, start);
  EXPECT_EQ(queue.front(), "a");
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

TEST(JobQueue, AnOwnerWhoMayNotStartIsPassedOver) {
  for (const auto half_life : {std::chrono::hours(24), std::chrono::hours(0)}) {
    JobQueue queue(half_life);
    queue.push(job_of("anna", "a", v1::NORMAL, start));
    queue.push(job_of("ben", "b", v1::NORMAL, start + 1));
    EXPECT_EQ(queue.front(), "a");
    EXPECT_EQ(queue.front([](Lane, const std::string& owner) { return owner != "anna"; }), "b");
    EXPECT_EQ(queue.front([](Lane, const std::string&) { return false; }), std::nullopt);
  }
}

/// Such a job once stood before all others, whether or not it might start.
TEST(JobQueue, AFollowedCastingThatMayNotStartStandsInNobodysWay) {
  JobQueue queue;
  queue.push(job_of("anna", "casting 1", v1::NORMAL, start), Lane::followed);
  queue.push(job_of("anna", "casting 2", v1::NORMAL, start + 1), Lane::followed);
  queue.push(job_of("ben", "casting 3", v1::NORMAL, start + 2), Lane::followed);
  queue.push(job_of("ben", "job", v1::NORMAL, start), Lane::job);
  EXPECT_EQ(queue.front(), "casting 1");
  EXPECT_EQ(queue.position("casting 2"), 3) << "owners take turns";
  EXPECT_EQ(queue.position("job"), 1);
  EXPECT_EQ(queue.front([](Lane lane, const std::string& owner) {
    return lane == Lane::job || owner != "anna";
  }),
            "casting 3");
  EXPECT_EQ(queue.front([](Lane lane, const std::string&) { return lane == Lane::job; }), "job");

  queue.push(job_of("eve", "query", v1::NORMAL, start + 9), Lane::query);
  EXPECT_EQ(queue.front([](Lane, const std::string&) { return false; }), "query");
  for (const char* id : {"query", "casting 1", "casting 2", "casting 3", "job"}) queue.erase(id);
  EXPECT_EQ(queue.front(), std::nullopt);
}

TEST(JobQueue, PositionsWithoutSharesAreThoseOfOneOrder) {
  JobQueue queue(std::chrono::seconds(0));
  for (int i = 0; i < 6; ++i)
    queue.push(job_of(i < 4 ? "anna" : "ben", std::to_string(i), v1::NORMAL, start + i));
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(queue.position(std::to_string(i)), 1);
    EXPECT_EQ(take_first(queue), std::to_string(i));
  }
}

}  // namespace
}  // namespace dccast::jobs
