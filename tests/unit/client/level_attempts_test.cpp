#include "client/level_attempts.hpp"

#include <gtest/gtest.h>

namespace dccast::client {
namespace {

v1::Job job(const std::string& request_id, v1::JobState state,
            v1::Failure::Kind kind = v1::Failure::WORKER_LOST) {
  v1::Job one;
  one.set_id("of " + request_id);
  one.set_request_id(request_id);
  one.set_state(state);
  if (state == v1::FAILED) one.mutable_failure()->set_kind(kind);
  return one;
}

TEST(LevelAttempts, AreReadFromTheRequestIdsOfTheStudy) {
  const auto levels =
      attempts_of("s", {job("s/1", v1::SUCCEEDED), job("s/4", v1::FAILED), job("s/4/3", v1::QUEUED),
                        job("t/2", v1::QUEUED), job("s/x", v1::QUEUED), job("s/4/0", v1::QUEUED),
                        job("s/2/", v1::QUEUED), job("mine", v1::QUEUED)});
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels.at(4).by_number.size(), 2u);
  EXPECT_EQ(levels.at(4).current()->request_id(), "s/4/3");
  EXPECT_EQ(levels.at(4).next_number(), 4);
}

TEST(LevelAttempts, RequestIdsFollowFromTheNumber) {
  EXPECT_EQ(attempt_request_id("s", 4, 1), "s/4");
  EXPECT_EQ(attempt_request_id("s", 4, 2), "s/4/2");
  EXPECT_EQ(LevelAttempts().next_number(), 1);
  EXPECT_EQ(LevelAttempts().current(), nullptr);
}

TEST(LevelAttempts, OnlyWhatCanEndOtherwiseIsRepaired) {
  const auto repairable = [](const std::vector<v1::Job>& jobs) {
    return attempts_of("s", jobs).at(1).can_be_repaired();
  };
  for (const auto kind : {v1::Failure::WORKER_LOST, v1::Failure::STORAGE, v1::Failure::INTERNAL,
                          v1::Failure::OTHER_VERSION, v1::Failure::WORKER_HUNG})
    EXPECT_TRUE(repairable({job("s/1", v1::FAILED, kind)})) << v1::Failure::Kind_Name(kind);
  for (const auto kind : {v1::Failure::SOLVE_FAILED, v1::Failure::CHECK_FAILED,
                          v1::Failure::INVALID_CASE, v1::Failure::SHELL_MELTED_THROUGH,
                          v1::Failure::MOTION_TOO_LARGE, v1::Failure::LIQUID_PRESSURE_LOST})
    EXPECT_FALSE(repairable({job("s/1", v1::FAILED, kind)})) << v1::Failure::Kind_Name(kind);
  EXPECT_TRUE(repairable({job("s/1", v1::CANCELLED)}));
  EXPECT_FALSE(repairable({job("s/1", v1::RUNNING)}));
  EXPECT_FALSE(repairable({job("s/1", v1::FAILED), job("s/1/2", v1::PAUSED)}));
  EXPECT_TRUE(repairable({job("s/1", v1::FAILED), job("s/1/2", v1::CANCELLED)}));
}

}  // namespace
}  // namespace dccast::client
