#include "server/jobs/queue/settlement.hpp"

#include <gtest/gtest.h>

#include "server/jobs/executors/worker_claim.hpp"

namespace dccast::jobs {
namespace {

using v1::RunEnd;

JobRecord running() {
  JobRecord record;
  record.job.set_state(v1::RUNNING);
  return record;
}

RunEnd failed(v1::Finding::Kind kind, const std::string& message) {
  RunEnd end;
  end.set_outcome(RunEnd::FAILED);
  end.mutable_failure()->set_kind(kind);
  end.mutable_failure()->set_message(message);
  return end;
}

TEST(Settlement, AFailedSolveKeepsItsCausesInOrder) {
  JobRecord record = running();
  auto end = failed(v1::Finding::CHECK_FAILED, "weight");
  end.mutable_failure()->add_further()->set_message("did not converge");
  const auto settlement = settle_run_end(record, end, {});
  EXPECT_EQ(settlement.state, v1::FAILED);
  EXPECT_EQ(settlement.cause, "weight");
  EXPECT_EQ(record.job.failure().further(0).message(), "did not converge");
}

TEST(Settlement, StorageTroubleIsTheDaemonsUntilAJobGetsNoFurther) {
  JobRecord record = running();
  const auto end = failed(v1::Finding::STORAGE, "No space left on device");
  const auto first = settle_run_end(record, end, {});
  EXPECT_EQ(first.state, v1::QUEUED);
  EXPECT_EQ(first.daemon_lacks, "No space left on device");
  EXPECT_FALSE(record.job.has_failure());
  const auto last = settle_run_end(record, end, {.storage_failures = 10});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::STORAGE);
}

TEST(Settlement, AJobWhoseOwnFilesAreDamagedFailsAlone) {
  const std::string damage = "readings.log: the header is damaged";
  JobRecord record = running();
  const auto ended =
      settle_run_end(record, failed(v1::Finding::STORAGE, "cannot be read"), {.damage = damage});
  EXPECT_EQ(ended.state, v1::FAILED);
  EXPECT_EQ(ended.daemon_lacks, "");
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::STORAGE);
  EXPECT_NE(record.job.failure().message().find(damage), std::string::npos);

  record = running();
  const auto lost = settle_lost(record, {"exit code 74", exit_storage},
                                {.storage_error = "could not write", .damage = damage});
  EXPECT_EQ(lost.state, v1::FAILED);
  EXPECT_EQ(lost.daemon_lacks, "");
}

TEST(Settlement, AFailedCheckWhoseResultsWereNotWrittenIsRunToItsEndAgain) {
  JobRecord record = running();
  auto end = failed(v1::Finding::CHECK_FAILED, "weight");
  v1::Finding& further = *end.mutable_failure()->add_further();
  further.set_kind(v1::Finding::STORAGE);
  further.set_message("No space left on device");
  const auto settlement = settle_run_end(record, end, {});
  EXPECT_EQ(settlement.state, v1::QUEUED);
  EXPECT_EQ(settlement.daemon_lacks, "No space left on device");
  const auto last = settle_run_end(record, end, {.storage_failures = 10});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::CHECK_FAILED);
}

TEST(Settlement, WhatWasAskedForComesAboutAlsoWhenStorageFails) {
  JobRecord record = running();
  record.requested_action = RequestedAction::cancel;
  record.request_reason = "wrong alloy";
  const auto settlement = settle_lost(record, {"signal 9"}, {.storage_error = "disk full"});
  EXPECT_EQ(settlement.state, v1::CANCELLED);
  EXPECT_EQ(settlement.cause, "cancelled: wrong alloy");
}

TEST(Settlement, AnotherVersionFollowsTheSetting) {
  RunEnd end;
  end.set_outcome(RunEnd::OTHER_VERSION_FOUND);
  end.mutable_failure()->set_kind(v1::Finding::OTHER_VERSION);
  end.mutable_failure()->set_message("written by 0.0.9");
  JobRecord record = running();
  EXPECT_EQ(settle_run_end(record, end, {.other_version = v1::PAUSE}).state, v1::PAUSED);
  EXPECT_FALSE(record.job.has_failure());
  EXPECT_EQ(settle_run_end(record, end, {.other_version = v1::FAIL}).state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::OTHER_VERSION);
}

TEST(Settlement, AWorkerThatRanOutOfMemoryFailsAtOnceWithThatKind) {
  JobRecord record = running();
  const auto settlement =
      settle_lost(record, {"exit code 71", exit_out_of_memory}, {.worker_restarts = 2});
  EXPECT_EQ(settlement.state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::OUT_OF_MEMORY);
  EXPECT_NE(settlement.cause.find("memory"), std::string::npos);
}

TEST(Settlement, ALossNamesTheFirstDeathAndTheStep) {
  JobRecord record = running();
  EXPECT_EQ(settle_lost(record, {"signal 11"}, {.worker_restarts = 1, .reached_step = 7}).state,
            v1::QUEUED);
  const auto last =
      settle_lost(record, {"exit code 1", 1}, {.worker_restarts = 1, .reached_step = 7});
  EXPECT_EQ(last.state, v1::FAILED);
  EXPECT_EQ(last.cause,
            "worker died with signal 11 after step 7; in all it died 2 times, twice in the step "
            "after 7");
}

TEST(Settlement, TheLastDeathNamesItsOwnStep) {
  JobRecord record = running();
  settle_lost(record, {"signal 11"}, {.worker_restarts = 2, .reached_step = 7});
  settle_lost(record, {"signal 11"}, {.worker_restarts = 2, .reached_step = 7});
  const auto last =
      settle_lost(record, {"exit code 1", 1}, {.worker_restarts = 2, .reached_step = 9});
  EXPECT_EQ(last.cause,
            "worker died with signal 11 after step 7; in all it died 3 times, at last: worker died "
            "with exit code 1 after step 9");
}

TEST(Settlement, AJobThatIsCancelledInSlurmIsCancelled) {
  JobRecord record = running();
  const auto end =
      settle_lost(record, {.how = "CANCELLED in Slurm", .cancelled = true}, {.worker_restarts = 2});
  EXPECT_EQ(end.state, v1::CANCELLED);
  EXPECT_EQ(end.cause, "cancelled in Slurm, not by dccast");
}

TEST(Settlement, AJobThatWasStoppedForItsTimeFailsUnlessItWasCancelledOrHasSucceeded) {
  const AttemptFacts facts{.shutting_down = true, .over_time = "it has run for 60 s"};
  RunEnd end;
  end.set_outcome(RunEnd::STOPPED);
  JobRecord record = running();

  EXPECT_EQ(settle_run_end(record, end, facts).state, v1::FAILED);
  EXPECT_EQ(record.job.failure().kind(), v1::Finding::TIME_LIMIT);
  EXPECT_NE(record.job.failure().message().find("--time-limit"), std::string::npos);

  record = running();
  EXPECT_EQ(settle_lost(record, {.how = "signal 9 (Killed)"}, facts).state, v1::FAILED);
  EXPECT_EQ(record.losses.times(), 0);

  record = running();
  record.requested_action = RequestedAction::cancel;
  EXPECT_EQ(settle_run_end(record, end, facts).state, v1::CANCELLED);

  record = running();
  end.set_outcome(RunEnd::SUCCEEDED);
  EXPECT_EQ(settle_run_end(record, end, facts).state, v1::SUCCEEDED);
}

}  // namespace
}  // namespace dccast::jobs
