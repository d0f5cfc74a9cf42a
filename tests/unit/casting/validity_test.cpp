#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <ostream>

#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::small_casting;

class Recorder : public testing::Recorder {
public:
  std::optional<results::ValidityLoss> lost;
  int times_lost = 0;
  void on_validity_lost(const results::ValidityLoss& loss) override {
    lost = loss;
    ++times_lost;
  }
};

struct Result {
  Recorder recorder;
  RunOutcome outcome;
  results::RunSummary summary;
};

Result result_of(const Case& c) {
  const TemporaryFolder folder;
  Result result;
  result.outcome = run(c, {folder / "", false}, result.recorder);
  results::ResultReader reader(folder / "results.h5");
  result.summary = reader.summary();
  EXPECT_EQ(reader.history().size(), result.recorder.reports.size());
  return result;
}

/// Switches all limits off, so that a single one can be tested.
void judge_the_shell_alone(Case& c) {
  c.validity.maximum_rotation = 3.2;
  c.validity.maximum_slip = 10.0;
}

constexpr double hot = 800.0, cold = 80.0;  // [°C]

/// Metal that is cast hot, on a block that a second after the start has another temperature [°C]: a
/// hot one melts the shell of the hold again.
Case melting_shell(double block_later) {
  Case c = small_casting(mesh::ElementKind::q1);
  judge_the_shell_alone(c);
  c.alloy.coherency = 620.0;
  c.schedule.casting_temperature = Curve(700.0);
  c.cooling.bottom_block.contact_coefficient = Curve(5000.0);
  c.cooling.bottom_block.temperature = {Abscissa::time, {0.0, 1.0}, {80.0, block_later}};
  c.coupling.gap_feedback = false;
  return c;
}

void expect_stopped(const Result& r, FailureKind kind, const char* key) {
  ASSERT_EQ(r.outcome.end, RunEnd::failed) << "nothing was found";
  ASSERT_EQ(r.outcome.failures.size(), 1u) << in_words(r.outcome.failures);
  const RunFailure& failure = r.outcome.failures[0];
  EXPECT_EQ(failure.kind, kind);
  EXPECT_THAT(failure.message, HasSubstr(key));
  EXPECT_EQ(failure.time, r.recorder.reports.back().time) << "it stops at once";
  EXPECT_EQ(failure.place.size(), 2u);
  EXPECT_EQ(r.summary.outcome, name_of(kind));
  EXPECT_EQ(r.summary.message, failure.message);
  ASSERT_TRUE(r.recorder.lost);
  EXPECT_EQ(r.recorder.times_lost, 1);
  EXPECT_EQ(r.summary.validity_lost, r.recorder.lost);
  EXPECT_EQ(r.recorder.lost->message, failure.message);
  for (const auto& report : r.recorder.reports)
    EXPECT_EQ(report.beyond_validity, report.time >= failure.time);
}

void expect_sound(const Result& r) {
  EXPECT_EQ(r.outcome.end, RunEnd::succeeded) << in_words(r.outcome.failures);
  EXPECT_FALSE(r.recorder.lost);
  EXPECT_FALSE(r.summary.validity_lost);
  for (const auto& report : r.recorder.reports) EXPECT_FALSE(report.beyond_validity);
}

double largest(const Result& r, double results::StepReport::*figure) {
  return std::ranges::max(r.recorder.reports, {}, figure).*figure;
}

struct Limit {
  const char* name;
  double results::StepReport::*figure;
  double Validity::*limit;
  FailureKind kind;
  const char* key;
};
void PrintTo(const Limit& l, std::ostream* out) {
  *out << l.name;
}

class LimitOf : public ::testing::TestWithParam<Limit> {};

/// A run without limits reports its largest values; a limit just below such a value ends the run,
/// one just above does not.
TEST_P(LimitOf, AStepStopsTheRunThatIsBeyondItAndNoOther) {
  Case c = small_casting(mesh::ElementKind::q1);
  const double reached = largest(result_of(c), GetParam().figure);
  ASSERT_GT(reached, 0.0);
  c.validity.*GetParam().limit = 0.999 * reached;
  const Result beyond = result_of(c);
  expect_stopped(beyond, GetParam().kind, GetParam().key);
  EXPECT_GT(beyond.recorder.lost->value, beyond.recorder.lost->limit);
  c.validity.*GetParam().limit = 1.001 * reached;
  expect_sound(result_of(c));
}

const Limit limits[] = {
    {"Rotation", &results::StepReport::maximum_rotation, &Validity::maximum_rotation,
     FailureKind::motion_too_large, "validity.maximum_rotation"},
    {"Slip", &results::StepReport::bottom_slip, &Validity::maximum_slip,
     FailureKind::motion_too_large, "validity.maximum_slip"},
};
INSTANTIATE_TEST_SUITE_P(Limits, LimitOf, ::testing::ValuesIn(limits),
                         [](const auto& limit) { return limit.param.name; });

TEST(Rotation, IsNoLimitOfElementsThatFollowIt) {
  Case c = small_casting(mesh::ElementKind::q1);
  c.mechanics.options.kinematics = mechanics::Kinematics::corotational;
  c.validity.maximum_rotation = 1e-5;
  const Result result = result_of(c);
  expect_sound(result);
  EXPECT_GT(largest(result, &results::StepReport::maximum_rotation), 1e-5);
}

TEST(ShellOfARun, ThatMeltsThroughEndsItWithItsTimeAndPlace) {
  const Result r = result_of(melting_shell(hot));
  expect_stopped(r, FailureKind::shell_melted_through, "melted through");
  EXPECT_EQ(r.recorder.lost->value, 0.0);
  EXPECT_EQ(r.recorder.lost->unit, "m");
  EXPECT_EQ(r.recorder.lost->place[1], 0.0) << "on the block";
}

TEST(ShellOfARun, ThatHoldsIsNoFinding) {
  expect_sound(result_of(melting_shell(cold)));
}

TEST(ShellOfARun, ThinnerThanTheCaseWantsIsAFinding) {
  Case c = melting_shell(cold);
  c.validity.minimum_shell = 5e-3;
  expect_sound(result_of(c));
  c = melting_shell(hot);
  c.validity.minimum_shell = 5e-3;
  const Result r = result_of(c);
  ASSERT_EQ(r.outcome.end, RunEnd::failed);
  EXPECT_EQ(r.recorder.lost->limit, 5e-3);
  EXPECT_LE(r.recorder.lost->time, result_of(melting_shell(hot)).recorder.lost->time);
}

/// A shell that never existed cannot melt through.
TEST(ShellOfARun, ThatHasYetToFormIsNoFinding) {
  Case c = small_casting(mesh::ElementKind::q1);
  judge_the_shell_alone(c);
  c.schedule.hold = 0.0;
  c.cooling.bottom_block.contact_coefficient = Curve(0.0);
  c.time.end = 3.0;
  expect_sound(result_of(c));
}

TEST(ShellOfARun, IsNotJudgedByHeatAlone) {
  Case c = melting_shell(hot);
  c.mechanics.enabled = false;
  expect_sound(result_of(c));
}

/// A billet is held by its hoop stress, whatever happens to the shell below its axis.
TEST(ShellOfARun, IsNotJudgedInARoundBillet) {
  Case c = melting_shell(hot);
  c.section.kind = mesh::SectionKind::axisymmetric;
  const Result r = result_of(c);
  EXPECT_FALSE(r.recorder.lost);
}

TEST(Continue, MarksEveryLaterStepAndTellsWhenInTheResults) {
  Case c = melting_shell(hot);
  const double lost_at = result_of(c).recorder.lost->time;
  c.validity.when_lost = WhenLost::go_on;
  const Result r = result_of(c);

  EXPECT_EQ(r.outcome.end, RunEnd::succeeded) << in_words(r.outcome.failures);
  EXPECT_EQ(r.summary.outcome, "succeeded");
  EXPECT_NEAR(r.recorder.reports.back().time, 20.0, 1e-9);
  ASSERT_TRUE(r.recorder.lost);
  EXPECT_EQ(r.recorder.times_lost, 1);
  EXPECT_EQ(r.recorder.lost->time, lost_at);
  EXPECT_EQ(r.summary.validity_lost, r.recorder.lost);
  for (const auto& report : r.recorder.reports)
    EXPECT_EQ(report.beyond_validity, report.time >= lost_at) << report.time;
}

/// Stopped before the loss, in the step of it and after it.
TEST(Continue, IsNotForgottenByAResumption) {
  for (const auto when_lost : {WhenLost::go_on, WhenLost::stop}) {
    Case c = melting_shell(hot);
    c.validity.when_lost = when_lost;
    const TemporaryFolder whole;
    Recorder uninterrupted;
    const RunOutcome outcome = run(c, {whole / "", false}, uninterrupted);
    const std::int64_t last = uninterrupted.reports.back().step;
    for (std::int64_t stop : {last / 2, last - 2, last - 1}) {
      const TemporaryFolder folder;
      Recorder first, second;
      first.act_after = stop;
      first.then = Order::stop_at_checkpoint;
      ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
      second.before = first.reports;
      const RunOutcome resumed = run(c, {folder / "", true}, second);
      EXPECT_EQ(second.resumed_from, stop);
      EXPECT_EQ(resumed.end, outcome.end);
      EXPECT_EQ(resumed.failures, outcome.failures);
      EXPECT_EQ(second.lost, uninterrupted.lost);
      EXPECT_TRUE(bytes_of(folder / "results.h5") == bytes_of(whole / "results.h5")) << stop;
    }
  }
}

}  // namespace
}  // namespace dccast::casting
