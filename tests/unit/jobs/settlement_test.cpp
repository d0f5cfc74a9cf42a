#include "server/jobs/settlement.hpp"

#include <gtest/gtest.h>

namespace dccast::jobs {
namespace {

using Finished = v1::WorkerMessage::Finished;

JobRecord running() {
  JobRecord record;
  record.job.set_state(v1::RUNNING);
  return record;
}

Finished failed(v1::Failure::Kind kind, const std::string& message) {
  Finished finished;
  finished.set_outcome(Finished::FAILED);
  finished.mutable_failure()->set_kind(kind);
  finished.mutable_failure()->set_message(message);
  return finished;
}

TEST(Settlement, AFailedSolveKeepsItsCausesInOrder) {
  JobRecord record = running();
  auto finished = failed(v1::Failure::CHECK_FAILED, "weight");
  finished.mutable_failure()->add_further_causes("did not converge");
  const auto settlement = settle_finished(record, finished, {});
  EXPECT_EQ(settlement.state, v1::FAILED);
  EXPECT_EQ(settlement.cause, "weight");
  EXPECT_EQ(record.job.failure().further_causes(0), "did not converge");
}

TEST(Settlement, StorageTroubleIsTheDaemonsUntilAJobGetsNoFurther) {
  JobRecord record = running();
  const auto finished = failed(v1::Failure::STORAGE, "No space left on device");
  const auto first = settle_finished(record, finished, {});
  EXPECT_EQ(first.state, v1::QUEUED);
  EXPECT_EQ(first.daemon_lacks, "No space left on device");
  EXPECT_FALSE(record.job.has_failure());
  const auto last = settle_finished(record, finished, {.storage_failures = 10});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Failure::STORAGE);
}

TEST(Settlement, AFailedCheckWhoseResultsWereNotWrittenIsRunToItsEndAgain) {
  JobRecord record = running();
  auto finished = failed(v1::Failure::CHECK_FAILED, "weight");
  finished.mutable_failure()->add_further_causes("STORAGE: No space left on device");
  const auto settlement = settle_finished(record, finished, {});
  EXPECT_EQ(settlement.state, v1::QUEUED);
  EXPECT_EQ(settlement.daemon_lacks, "No space left on device");
  const auto last = settle_finished(record, finished, {.storage_failures = 10});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Failure::CHECK_FAILED);
}

TEST(Settlement, WhatWasAskedForComesAboutAlsoWhenStorageFails) {
  JobRecord record = running();
  record.requested_action = RequestedAction::cancel;
  record.request_reason = "wrong alloy";
  const auto settlement = settle_lost(record, "signal 9", {.storage_error = "disk full"});
  EXPECT_EQ(settlement.state, v1::CANCELLED);
  EXPECT_EQ(settlement.cause, "cancelled: wrong alloy");
}

TEST(Settlement, AnotherVersionFollowsTheSetting) {
  Finished finished;
  finished.set_outcome(Finished::OTHER_VERSION_FOUND);
  finished.mutable_failure()->set_kind(v1::Failure::OTHER_VERSION);
  finished.mutable_failure()->set_message("written by 0.0.9");
  JobRecord record = running();
  EXPECT_EQ(settle_finished(record, finished, {.other_version = v1::PAUSE}).state, v1::PAUSED);
  EXPECT_FALSE(record.job.has_failure());
  EXPECT_EQ(settle_finished(record, finished, {.other_version = v1::FAIL}).state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Failure::OTHER_VERSION);
}

TEST(Settlement, ALossNamesTheFirstDeathAndTheStep) {
  JobRecord record = running();
  EXPECT_EQ(settle_lost(record, "signal 11", {.worker_restarts = 1, .reached_step = 7}).state,
            v1::QUEUED);
  const auto last = settle_lost(record, "exit code 1", {.worker_restarts = 1, .reached_step = 7});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(last.cause,
            "worker died with signal 11 after step 7; in all it died 2 times, twice in the step "
            "after 7");
}

}  // namespace
}  // namespace dccast::jobs
