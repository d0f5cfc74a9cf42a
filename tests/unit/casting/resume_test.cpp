#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "core/casting/stored_run.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::equal_except_timing;
using testing::Recorder;
using testing::small_casting;

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
    second.before = first.reports;
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

/// A mould that is filled, a film that wets by and by, a block that warms up.
TEST_P(Resume, GivesTheSameBytesOfAFilledStart) {
  Case c = small_casting(GetParam());
  c.schedule.filling = 6.0;
  c.cooling.top = thermal::Top::pouring;
  c.cooling.level_coefficient = 10.0;
  c.cooling.water.boiling_follows_flow = true;
  c.cooling.water.wetting = thermal::testing::wetting();
  c.cooling.bottom_block.body = thermal::BlockBody{0.15, 170.0, 2.6e6, 200.0};
  c.cooling.bottom_block.wet_coefficient = 1000.0;
  c.cooling.bottom_block.wet_gap = 1e-3;
  expect_same_after_stops(c, {3, 6, 12, 30});

  c.cooling.bottom_block.wet_coefficient.reset();
  c.cooling.bottom_block.gap_water = thermal::GapWater{0.5, 0.6, 2000.0, 0.3};
  c.cooling.bottom_block.wet_gap = 0.1e-3;
  expect_same_after_stops(c, {6, 30});
}

/// Every algorithm that carries something of its own from step to step.
TEST_P(Resume, GivesTheSameBytesByTheOtherAlgorithm) {
  Case c = small_casting(GetParam());
  c.mechanics.options.algorithm = mechanics::Algorithm::vnbm;
  c.mechanics.options.tolerance = 1e-7;
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

  second.before = first.reports;
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
    second.before = first.reports;
    ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
    // The checkpoint of a step is written after the observer has seen it.
    const std::int64_t last = (stop - 1) / 7 * 7;
    EXPECT_EQ(second.resumed_from, last > 0 ? last : -1);
    EXPECT_EQ(second.messages.empty(), last > 0) << "that it starts over is said";
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
  EXPECT_EQ(second.messages,
            std::vector<std::string>{"no checkpoint to continue from (it is of another case): the "
                                     "run starts from the beginning"});
  EXPECT_EQ(second.reports.front().step, 1);
}

/// A checkpoint after step 3 by a program that calls itself `solver`.
void leave_checkpoint_of(const std::string& solver, const TemporaryFolder& folder) {
  Recorder recorder;
  recorder.act_after = 3;
  recorder.then = Order::stop_at_checkpoint;
  ASSERT_EQ(run(small_casting(), {folder / "", false}, recorder).end, RunEnd::stopped);
  results::Sections content = *results::read_checkpoint(folder / "checkpoint.bin").content;
  content.set("solver", solver);
  results::write_checkpoint(folder / "checkpoint.bin", content);
}

TEST(CheckpointOfAnotherVersion, LetsTheRunBeginAnewAndSaysWhy) {
  const TemporaryFolder folder;
  leave_checkpoint_of("dccast 0.0.9", folder);
  Recorder recorder;
  ASSERT_EQ(run(small_casting(), {folder / "", true}, recorder).end, RunEnd::succeeded);
  EXPECT_EQ(recorder.resumed_from, -1);
  EXPECT_EQ(recorder.reports.front().step, 1);
  ASSERT_EQ(recorder.messages.size(), 1u);
  EXPECT_EQ(recorder.messages[0],
            "no checkpoint to continue from (it is of another version: dccast 0.0.9; this is " +
                solver_identity() + "): the run starts from the beginning");
}

TEST(CheckpointOfAnotherVersion, WaitsUntilToldToBeginAnew) {
  const TemporaryFolder folder;
  leave_checkpoint_of("dccast 0.0.9", folder);
  Recorder waiting, anew;
  const RunOutcome outcome = run(small_casting(), {folder / "", true, OtherVersion::wait}, waiting);

  EXPECT_EQ(outcome.end, RunEnd::other_version);
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_EQ(outcome.failures[0].kind, FailureKind::other_version);
  EXPECT_NE(outcome.failures[0].message.find("dccast 0.0.9"), std::string::npos);
  EXPECT_TRUE(waiting.reports.empty());
  EXPECT_TRUE(std::filesystem::exists(folder / "checkpoint.bin")) << "the version may come back";

  anew.act_after = 2;
  anew.die = true;
  EXPECT_THROW(run(small_casting(), {folder / "", true, OtherVersion::begin_anew}, anew),
               Recorder::Killed);

  Recorder last;
  EXPECT_EQ(run(small_casting(), {folder / "", true, OtherVersion::wait}, last).end,
            RunEnd::succeeded)
      << "started over once, it does not meet the old checkpoint again";
}

TEST(CheckpointOfAnotherVersion, FailsTheRunWhereTheCaseIsSo) {
  const TemporaryFolder folder;
  leave_checkpoint_of("dccast 0.0.9", folder);
  Recorder recorder;
  const RunOutcome outcome =
      run(small_casting(), {folder / "", true, OtherVersion::fail}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::failed);
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_EQ(outcome.failures[0].kind, FailureKind::other_version);
  EXPECT_FALSE(std::filesystem::exists(folder / "checkpoint.bin"));
}

TEST(CheckpointOfAnotherVersion, IsAlsoOneOfAnotherFormat) {
  const TemporaryFolder folder;
  leave_checkpoint_of("dccast 0.0.9", folder);
  {
    std::fstream file(folder / "checkpoint.bin", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(8);
    file.put(7);
  }
  Recorder recorder;
  const RunOutcome outcome =
      run(small_casting(), {folder / "", true, OtherVersion::wait}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::other_version);
  EXPECT_NE(outcome.failures.at(0).message.find("checkpoint format 7"), std::string::npos);
}

/// The results are made of the reports: without one of them the run starts over.
TEST_P(Resume, StartsOverWhereAReportIsLost) {
  Case c = small_casting(GetParam());
  c.time.end = 6.0;
  std::int64_t steps = 0;
  const std::string whole = uninterrupted(c, steps);
  for (const std::ptrdiff_t lost : {0, 6, 13}) {
    const TemporaryFolder folder;
    Recorder first, second;
    first.act_after = 14;
    first.then = Order::stop_at_checkpoint;
    ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
    second.before = first.reports;
    second.before.erase(second.before.begin() + lost);
    ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
    EXPECT_EQ(second.resumed_from, -1);
    EXPECT_EQ(second.messages,
              std::vector<std::string>{"no checkpoint to continue from (a step before it is lost): "
                                       "the run starts from the beginning"});
    EXPECT_TRUE(bytes_of(folder / "results.h5") == whole);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, Resume,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1,
                                           mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
