#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

class Run : public ::testing::TestWithParam<mesh::ElementKind> {};

TEST_P(Run, EveryStepPassesItsChecks) {
  const TemporaryFolder folder;
  Recorder recorder;
  const Case c = small_casting(GetParam());
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);

  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  EXPECT_TRUE(outcome.failures.empty());
  ASSERT_FALSE(recorder.reports.empty());
  EXPECT_EQ(check(c).estimate.steps, static_cast<std::int64_t>(recorder.reports.size()));
  EXPECT_EQ(check(c).estimate.nodes, recorder.reports.back().nodes);
  EXPECT_EQ(check(c).estimate.elements, recorder.reports.back().elements);

  std::int64_t step = 0;
  double time = -10.0;
  for (const auto& r : recorder.reports) {
    EXPECT_EQ(r.step, ++step);
    EXPECT_NEAR(r.time, time + r.time_step, 1e-9);
    time = r.time;
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_NEAR(r.cast_length, 1e-3 * std::max(0.0, r.time), 1e-12);
    EXPECT_NEAR(r.progress, (r.time + 10.0) / 30.0, 1e-9);
    if (r.time <= 1e-9) {
      EXPECT_EQ(r.weight, 0.0) << "the mechanics starts at zero";
      continue;
    }
    EXPECT_GT(r.weight, 600.0);
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-4 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance);
    EXPECT_LE(r.complementarity_error, 1e-5);
    EXPECT_EQ(r.failed_attempts, 0);
  }

  const auto& last = recorder.reports.back();
  EXPECT_NEAR(last.time, 20.0, 1e-9);
  EXPECT_EQ(last.progress, 1.0);
  EXPECT_GT(last.wall_heat_flux, 0.0);
  EXPECT_GT(last.sump_depth, 0.0);
  EXPECT_LT(last.mould_exit_temperature, 640.0);
  EXPECT_GT(std::abs(last.monitor_displacement[0][0]), 1e-5) << "the corner has left the mould";
  EXPECT_EQ(last.monitor_displacement[1][0], 0.0) << "the axis of symmetry stays";
}

TEST_P(Run, AMonitorIsSilentUntilItsMetalIsPoured) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(small_casting(GetParam()), {folder / "", false}, recorder).end, RunEnd::succeeded);
  for (const auto& r : recorder.reports) {
    EXPECT_EQ(std::isnan(r.monitor_displacement[2][0]), r.cast_length < 0.015 - 1e-9) << r.time;
  }
}

TEST_P(Run, TheFileHoldsWhatTheObserverSaw) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(small_casting(GetParam()), {folder / "", false}, recorder).end, RunEnd::succeeded);
  EXPECT_FALSE(std::filesystem::exists(folder / "checkpoint.bin"));
  EXPECT_TRUE(std::filesystem::exists(folder / "results.xdmf"));

  const results::ResultReader reader(folder / "results.h5");
  const auto history = reader.history();
  ASSERT_EQ(history.size(), recorder.reports.size());
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_EQ(history[i].time, recorder.reports[i].time);
    EXPECT_EQ(history[i].monitor_displacement[0], recorder.reports[i].monitor_displacement[0]);
    EXPECT_EQ(history[i].bottom_reaction, recorder.reports[i].bottom_reaction);
  }
  EXPECT_EQ(reader.frames(), 7u) << "every five seconds from -10 to 20";
  EXPECT_NEAR(reader.frame(6).metal_level, 0.12, 1e-12);
  EXPECT_EQ(reader.header().title, "a small casting");
}

TEST_P(Run, KeepsNothingWhereNothingIsWantedAndComputesTheSame) {
  const TemporaryFolder kept, empty;
  Recorder with, without;
  Case c = small_casting(GetParam());
  c.checkpoint.every_steps = 2;
  ASSERT_EQ(run(c, {.path = kept / ""}, with).end, RunEnd::succeeded);
  ASSERT_EQ(run(c, {.path = empty / "", .keeps_nothing = true}, without).end, RunEnd::succeeded);
  EXPECT_TRUE(std::filesystem::is_empty(empty / ""));
  ASSERT_EQ(without.reports.size(), with.reports.size());
  EXPECT_EQ(without.reports.back().monitor_displacement[0],
            with.reports.back().monitor_displacement[0]);
}

INSTANTIATE_TEST_SUITE_P(Elements, Run,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1,
                                           mesh::ElementKind::q1_bending));

/// A round billet passes the same checks. By metre of its circumference it weighs half of what a
/// slab of the same half width does by metre of its face.
TEST(RoundBillet, EveryStepPassesItsChecks) {
  const TemporaryFolder folder;
  Recorder recorder, plane;
  Case c = small_casting(mesh::ElementKind::q1);
  ASSERT_EQ(run(c, {folder / "", false}, plane).end, RunEnd::succeeded);

  c.section.kind = mesh::SectionKind::axisymmetric;
  EXPECT_TRUE(check(c).faults.empty());

  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  for (const auto& r : recorder.reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    if (r.time <= 1e-9) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-4 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance);
    EXPECT_LE(r.complementarity_error, 1e-5);
    EXPECT_LE(r.contact_length, 0.28 + 1e-12);
  }

  const auto &last = recorder.reports.back(), &slab = plane.reports.back();
  EXPECT_NEAR(2.0 * last.weight, slab.weight, 0.01 * slab.weight);
  EXPECT_LT(last.monitor_displacement[0][0], -1e-5) << "the rim has left the mould";
  EXPECT_EQ(last.monitor_displacement[1][0], 0.0) << "the axis stays";
  EXPECT_EQ(results::ResultReader(folder / "results.h5").header().section, "axisymmetric");
}

TEST(RunEnds, CancelLeavesAtOnce) {
  const TemporaryFolder folder;
  Recorder recorder;
  recorder.act_after = 4;
  recorder.then = Order::cancel;
  EXPECT_EQ(run(small_casting(), {folder / "", false}, recorder).end, RunEnd::cancelled);
  EXPECT_EQ(recorder.reports.size(), 4u);
  EXPECT_FALSE(std::filesystem::exists(folder / "results.h5"));
}

/// Mechanics that may not iterate at all: the step is cut to the minimum, then the run has failed.
TEST(RunEnds, ASolveThatFailsSaysWhenAndWithWhatResiduals) {
  const TemporaryFolder folder;
  Recorder recorder;
  Case c = small_casting();
  c.mechanics.options.maximum_iterations = 0;
  c.time.minimum_step = 0.02;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);

  ASSERT_EQ(outcome.end, RunEnd::failed);
  ASSERT_EQ(outcome.failures.size(), 1u);

  const RunFailure& failure = outcome.failures.front();
  EXPECT_EQ(failure.kind, FailureKind::solve_failed);
  EXPECT_NEAR(failure.time, 0.0, 1e-9) << "where the mechanics starts";
  EXPECT_GE(failure.time_step, 0.02);
  EXPECT_LT(failure.time_step, 0.04);
  ASSERT_FALSE(failure.residual_history.empty());
  EXPECT_GT(failure.residual_history.back(), 1e-7);
  EXPECT_THAT(failure.message, ::testing::HasSubstr("time.minimum_step"));
  EXPECT_FALSE(recorder.reports.empty()) << "the hold went well";

  const results::ResultReader reader(folder / "results.h5");
  EXPECT_EQ(reader.history().size(), recorder.reports.size()) << "what there was is kept";
}

/// The small casting with such a large tolerance that the bottom reaction is wrong, and the solve
/// finally fails.
Case check_fails_then_solve() {
  Case c = small_casting(mesh::ElementKind::q1);
  c.mechanics.options.tolerance = 3e-2;
  c.mechanics.options.maximum_iterations = 15;
  c.time.minimum_step = 0.12;
  return c;
}

TEST(RunEnds, ASolveThatFailsDoesNotHideTheCheckThatFailedBefore) {
  const TemporaryFolder folder;
  Recorder recorder;
  const RunOutcome outcome = run(check_fails_then_solve(), {folder / "", false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::failed);
  ASSERT_EQ(outcome.failures.size(), 2u);
  EXPECT_EQ(outcome.failures[0].kind, FailureKind::check_failed);
  EXPECT_LE(outcome.failures[0].time, outcome.failures[1].time) << "that of the last good step";
  EXPECT_EQ(outcome.failures[1].kind, FailureKind::solve_failed);
  EXPECT_FALSE(outcome.failures[1].residual_history.empty());
  const auto summary = results::ResultReader(folder / "results.h5").summary();
  EXPECT_EQ(summary.outcome, "check_failed");
  EXPECT_THAT(summary.message, ::testing::HasSubstr("; then solve_failed: the mechanical step"));
}

TEST(RunEnds, TheForcesOfAFailedCheckHaveTheUnitOfTheSection) {
  Case solid = testing::small_quarter_slab();
  solid.mechanics.options.tolerance = 0.3;
  const auto message_of = [](const Case& c) {
    const TemporaryFolder folder;
    Recorder recorder;
    const RunOutcome outcome = run(c, {folder / "", false}, recorder);
    return outcome.failures.empty() ? "no failure" : outcome.failures.front().message;
  };
  EXPECT_THAT(message_of(check_fails_then_solve()), ::testing::ContainsRegex(" N/m at t = "));
  EXPECT_THAT(message_of(solid), ::testing::ContainsRegex("[0-9] N at t = "));
}

/// A folder in the way of results.h5, from the first step on: publishing fails.
class InTheWay : public Recorder {
public:
  explicit InTheWay(std::filesystem::path results) : results_(std::move(results)) {}
  Order on_step(const results::StepReport& report) override {
    std::filesystem::create_directories(results_ / "full");
    return Recorder::on_step(report);
  }

private:
  std::filesystem::path results_;
};

TEST(RunEnds, AStorageFaultAtTheEndDoesNotReplaceTheCause) {
  const TemporaryFolder folder;
  InTheWay observer(folder / "results.h5");
  Case c = check_fails_then_solve();
  c.checkpoint.every_steps = 5;
  const RunOutcome outcome = run(c, {folder / "", false}, observer);
  EXPECT_EQ(outcome.end, RunEnd::failed);
  ASSERT_EQ(outcome.failures.size(), 3u);
  EXPECT_EQ(outcome.failures[0].kind, FailureKind::check_failed);
  EXPECT_EQ(outcome.failures[1].kind, FailureKind::solve_failed);
  EXPECT_EQ(outcome.failures[2].kind, FailureKind::storage);
  EXPECT_THAT(outcome.failures[2].message, ::testing::HasSubstr("results.h5"));
}

/// Files needed for a resumption are removed at the end, unless the results could not be written.
TEST(RunEnds, JournalAndCheckpointStayOnlyForARetry) {
  const TemporaryFolder folder;
  Case c = small_casting();
  c.time.end = 1.0;
  c.checkpoint.every_steps = 4;
  InTheWay observer(folder / "results.h5");
  const RunOutcome outcome = run(c, {folder / "", false}, observer);
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_EQ(outcome.failures[0].kind, FailureKind::storage);
  EXPECT_TRUE(std::filesystem::exists(folder / "journal.bin"));
  EXPECT_TRUE(std::filesystem::exists(folder / "checkpoint.bin"));

  std::filesystem::remove_all(folder / "results.h5");
  Recorder retry;
  retry.before = observer.reports;
  EXPECT_EQ(run(c, {folder / "", true}, retry).end, RunEnd::succeeded);
  EXPECT_EQ(retry.resumed_from, 12);
  EXPECT_FALSE(std::filesystem::exists(folder / "journal.bin"));
  EXPECT_FALSE(std::filesystem::exists(folder / "checkpoint.bin"));
}

TEST(RunEnds, JournalAndCheckpointGoWithAFailureAndWithACancel) {
  for (const bool cancel : {false, true}) {
    const TemporaryFolder folder;
    Recorder recorder;
    Case c = check_fails_then_solve();
    c.checkpoint.every_steps = 4;
    if (cancel) recorder.act_after = 9;
    recorder.then = Order::cancel;
    const RunOutcome outcome = run(c, {folder / "", false}, recorder);
    EXPECT_EQ(outcome.end, cancel ? RunEnd::cancelled : RunEnd::failed);
    EXPECT_EQ(std::filesystem::exists(folder / "results.h5"), !cancel);
    EXPECT_FALSE(std::filesystem::exists(folder / "journal.bin"));
    EXPECT_FALSE(std::filesystem::exists(folder / "checkpoint.bin"));
  }
}

/// Steps that do not converge are reduced and grow back; the casting is completed nevertheless.
TEST(RunEnds, StepsAreCutAndGrowBack) {
  const TemporaryFolder folder;
  Recorder recorder;
  Case c = small_casting();
  c.mechanics.options.maximum_iterations = 10;
  c.time.minimum_step = 1e-6;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);

  int failed = 0;
  for (const auto& r : recorder.reports) {
    failed += r.failed_attempts;
    EXPECT_LE(r.iterations, 10);
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "dt = " << r.time_step;
  }
  EXPECT_GT(failed, 0);
  EXPECT_NEAR(recorder.reports.back().time, 20.0, 1e-9);
}

}  // namespace
}  // namespace dccast::casting
