#include <gtest/gtest.h>

#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::Recorder;
using testing::small_casting;
using testing::TemporaryFolder;

std::string uninterrupted(const Case& c, std::int64_t& steps, int* failed_attempts = nullptr) {
  const TemporaryFolder folder;
  Recorder recorder;
  EXPECT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);
  steps = recorder.reports.back().step;
  for (const auto& r : recorder.reports) {
    if (failed_attempts != nullptr) *failed_attempts += r.failed_attempts;
  }
  return bytes_of(folder / "results.h5");
}

void expect_same_after_stops(const Case& c, std::initializer_list<std::int64_t> stops) {
  std::int64_t steps = 0;
  const std::string whole = uninterrupted(c, steps);
  for (std::int64_t stop : stops) {
    ASSERT_LT(stop, steps);
    const TemporaryFolder folder;
    Recorder first;
    first.act_after = stop;
    first.then = Order::stop_at_checkpoint;
    ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
    EXPECT_EQ(first.reports.size(), std::size_t(stop));
    Recorder second;
    ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
    EXPECT_EQ(second.resumed_from, stop);
    EXPECT_EQ(second.reports.front().step, stop + 1);
    EXPECT_TRUE(bytes_of(folder / "results.h5") == whole) << "stopped after step " << stop;
  }
}

class Resume : public ::testing::TestWithParam<mesh::ElementKind> {};

/// In the hold, at the start of the block, while rows are added, before the last step.
TEST_P(Resume, GivesTheSameBytesWhereverItStopped) {
  expect_same_after_stops(small_casting(GetParam()), {1, 10, 12, 30, 40});
}

TEST_P(Resume, GivesTheSameBytesAmidCutSteps) {
  Case c = small_casting(GetParam());
  c.mechanics.options.maximum_iterations = 6;
  c.time.minimum_step = 1e-6;
  c.time.end = 6.0;
  std::int64_t steps = 0;
  int failed_attempts = 0;
  uninterrupted(c, steps, &failed_attempts);
  ASSERT_GT(failed_attempts, 0);
  expect_same_after_stops(c, {9, 12, 13, 14, 20});
}

/// Every algorithm that carries something of its own from step to step.
TEST_P(Resume, GivesTheSameBytesByTheOtherAlgorithm) {
  Case c = small_casting(GetParam());
  c.mechanics.options.algorithm = mechanics::Algorithm::vnbm;
  c.mechanics.options.tolerance = 1e-6;
  c.time.end = 6.0;
  expect_same_after_stops(c, {12, 20});
}

/// A check that failed before the checkpoint: found by a user whose run "succeeded" after a pause.
TEST_P(Resume, KeepsACheckThatFailed) {
  Case c = small_casting(GetParam());
  c.mechanics.options.tolerance = 3e-3;
  c.time.end = 6.0;
  const TemporaryFolder whole;
  Recorder uninterrupted;
  const RunOutcome outcome = run(c, {whole / "", false}, uninterrupted);
  ASSERT_EQ(outcome.failures.size(), 1u);
  ASSERT_EQ(outcome.failures[0].kind, FailureKind::check_failed);
  const TemporaryFolder folder;
  Recorder first, second;
  first.act_after = uninterrupted.reports.back().step - 1;
  first.then = Order::stop_at_checkpoint;
  ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
  const RunOutcome resumed = run(c, {folder / "", true}, second);
  EXPECT_EQ(second.resumed_from, first.act_after);
  EXPECT_EQ(resumed.end, RunEnd::failed);
  EXPECT_EQ(resumed.failures, outcome.failures);
  EXPECT_TRUE(bytes_of(folder / "results.h5") == bytes_of(whole / "results.h5"));
}

/// The process dies between checkpoints: steps after the last one are made again.
TEST_P(Resume, AfterAKillGoesOnFromTheLastCheckpoint) {
  Case c = small_casting(GetParam());
  c.checkpoint.every_steps = 7;
  std::int64_t steps = 0;
  const std::string whole = uninterrupted(c, steps);
  for (std::int64_t stop : {5, 7, 13, 27}) {
    const TemporaryFolder folder;
    Recorder first;
    first.act_after = stop;
    first.die = true;
    EXPECT_THROW(run(c, {folder / "", false}, first), Recorder::Killed);
    Recorder second;
    ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
    // The checkpoint of a step is written after the observer has seen it.
    const std::int64_t last = (stop - 1) / 7 * 7;
    EXPECT_EQ(second.resumed_from, last > 0 ? last : -1);
    EXPECT_EQ(second.messages.empty(), last > 0) << "that it begins anew is said";
    EXPECT_TRUE(bytes_of(folder / "results.h5") == whole) << "killed after step " << stop;
  }
}

TEST_P(Resume, TakesNoCheckpointOfAnotherCase) {
  const TemporaryFolder folder;
  Case c = small_casting(GetParam());
  Recorder first;
  first.act_after = 3;
  first.then = Order::stop_at_checkpoint;
  ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
  c.source_json = R"({"title": "another"})";
  Recorder second;
  ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
  EXPECT_EQ(second.resumed_from, -1);
  EXPECT_EQ(second.messages.size(), 1u);
  EXPECT_EQ(second.reports.front().step, 1);
}

INSTANTIATE_TEST_SUITE_P(Elements, Resume,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1,
                                           mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
