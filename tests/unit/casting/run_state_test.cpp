// A checkpoint contains the complete state of a run, and a damaged checkpoint never corrupts a run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/casting/run_state.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/checkpoint_file.hpp"
#include "tests/unit/casting/small_casting.hpp"
#include "tests/unit/casting/stopped_runs.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::expect_equal;
using testing::Given;
using testing::Recorder;
using testing::run_with_stops;
using testing::small_casting;

/// Stops at single steps, near the start of the mechanics and before the end, and then after every
/// step of one run.
/// @return the uninterrupted run
Given expect_no_state_outside(const Case& c) {
  const Given whole = run_with_stops(c, {});
  const std::int64_t last = whole.reports.back().step;
  std::vector<std::int64_t> all;
  for (std::int64_t step = 1; step < last; ++step) all.push_back(step);
  for (const std::int64_t stop : {std::int64_t{11}, std::int64_t{13}, last - 1}) {
    SCOPED_TRACE("stopped after step " + std::to_string(stop));
    expect_equal(run_with_stops(c, {stop}), whole);
  }
  SCOPED_TRACE("stopped after every step");
  expect_equal(run_with_stops(c, all), whole);
  return whole;
}

class NoStateOutsideTheCheckpoint : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  Case short_casting() const {
    Case c = small_casting(GetParam());
    c.time.end = 1.5;
    c.output.frame_interval = 0.6;
    return c;
  }
};

TEST_P(NoStateOutsideTheCheckpoint, OfARunWhoseWaterFollowsItsFlow) {
  Case c = short_casting();
  c.cooling.water.boiling_follows_flow = true;
  c.cooling.water.pulse_period = 0.5;
  c.cooling.water.pulse_end = 1.2;
  c.coupling.deformed_zones = true;
  EXPECT_EQ(expect_no_state_outside(c).reports.back().progress, 1.0);
}

TEST_P(NoStateOutsideTheCheckpoint, OfARunThatFailsACheck) {
  Case c = short_casting();
  c.mechanics.options.tolerance = 3e-3;
  const Given whole = expect_no_state_outside(c);
  ASSERT_EQ(whole.outcome.failures.size(), 1u);
  EXPECT_EQ(whole.outcome.failures[0].kind, FailureKind::check_failed);
  EXPECT_LT(whole.outcome.failures[0].time, whole.reports.back().time) << "with steps after it";
}

TEST_P(NoStateOutsideTheCheckpoint, OfARunBySbmWhichCarriesAMultiplier) {
  Case c = short_casting();
  c.time.end = 0.75;
  c.mechanics.options.algorithm = mechanics::Algorithm::sbm;
  c.mechanics.options.tolerance = 1e-3;
  c.mechanics.options.maximum_iterations = 8000;
  const Given whole = expect_no_state_outside(c);
  EXPECT_EQ(whole.reports.back().progress, 1.0);
}

TEST_P(NoStateOutsideTheCheckpoint, OfARunWhoseStepsWereCut) {
  Case c = short_casting();
  c.mechanics.options.maximum_iterations = 6;
  c.time.minimum_step = 1e-6;
  c.time.end = 0.5;
  const Given whole = expect_no_state_outside(c);
  int failed_attempts = 0;
  for (const auto& report : whole.reports) failed_attempts += report.failed_attempts;
  EXPECT_GT(failed_attempts, 0);
}

INSTANTIATE_TEST_SUITE_P(Elements, NoStateOutsideTheCheckpoint,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

/// A check fails, then the solve: both are reported after any stop.
TEST(NoStateOutside, OfARunThatFailsASolve) {
  Case c = small_casting(mesh::ElementKind::q1);
  c.mechanics.options.tolerance = 3e-2;
  c.mechanics.options.maximum_iterations = 15;
  c.time.minimum_step = 0.12;
  const Given whole = run_with_stops(c, {});
  ASSERT_EQ(whole.outcome.failures.size(), 2u);
  EXPECT_EQ(whole.outcome.failures[0].kind, FailureKind::check_failed);
  EXPECT_EQ(whole.outcome.failures[1].kind, FailureKind::solve_failed);
  expect_equal(run_with_stops(c, {5, 11}), whole);
}

/// A checkpoint with its journal, and damage that the checksum does not detect.
class Damage : public ::testing::Test {
protected:
  void SetUp() override {
    c_.time.end = 2.0;
    c_.mechanics.options.tolerance = 3e-3;  // with a failure in the state
    Recorder recorder;
    recorder.act_after = 17;
    recorder.then = Order::stop_at_checkpoint;
    ASSERT_EQ(run(c_, {folder_ / "", false}, recorder).end, RunEnd::stopped);
    content_ = *results::read_checkpoint(folder_ / "checkpoint.bin").content;
    journal_ = bytes_of(folder_ / "journal.bin");
    steps_ = recorder.reports;
  }

  /// Goes on from `content` for one step. @return what the run said, and "resumed" where it did
  std::string resume_from(const results::Sections& content) {
    results::write_checkpoint(folder_ / "checkpoint.bin", content);
    std::ofstream(folder_ / "journal.bin", std::ios::binary) << journal_;
    Recorder recorder;
    recorder.before = steps_;
    recorder.die = true;
    recorder.act_after = 18;
    try {
      recorder.messages.push_back(in_words(run(c_, {folder_ / "", true}, recorder).failures));
    } catch (const Recorder::Killed&) {
    }
    if (recorder.resumed_from >= 0) return "resumed";
    return recorder.messages.empty() ? "" : recorder.messages.front();
  }

  const TemporaryFolder folder_;
  Case c_ = small_casting(mesh::ElementKind::q1);
  results::Sections content_;
  std::string journal_;
  std::vector<results::StepReport> steps_;
};

TEST_F(Damage, OfNoArrayIsTakenForAState) {
  ASSERT_EQ(resume_from(content_), "resumed");

  for (const auto& [name, value] : content_.all()) {
    if (const auto* reals = std::get_if<results::Sections::Reals>(&value)) {
      if (name.starts_with("failure"))
        continue;  // may have any length and does not depend on the mesh
      const bool of_finding = name.starts_with("finding");
      for (const int change : {-3, -1, 1, 4}) {
        auto longer = *reals;
        longer.resize(std::size_t(std::max(0, int(reals->size()) + change)), 1.0);
        // A single number: only the first value is read.
        if (reals->size() == 1 && change > 0 && !of_finding) continue;
        // A finding has each of its numbers at most once, and at most one place.
        if (of_finding && longer.size() <= (name.ends_with("place_m") ? 0 : 1)) continue;
        if (longer == *reals) continue;
        results::Sections content = content_;
        content.set(name, longer);
        EXPECT_THAT(resume_from(content), ::testing::HasSubstr("starts from the beginning"))
            << name << " by " << change;
      }
    }
  }
}

TEST_F(Damage, NamesTheArray) {
  results::Sections content = content_;
  auto strain = content.reals("slab/inelastic_strain");
  strain.resize(strain.size() - 4);
  content.set("slab/inelastic_strain", strain);
  EXPECT_THAT(resume_from(content), ::testing::HasSubstr("inelastic strain has 2"));
  strain.pop_back();
  content.set("slab/inelastic_strain", strain);
  EXPECT_THAT(resume_from(content),
              ::testing::HasSubstr("'slab/inelastic_strain' has incomplete tensors"));
}

/// Flipped bits and missing bytes, each with a matching checksum: the run continues, starts
/// from the beginning or reports a failure. The seed is fixed, so that a failure can be reproduced.
TEST_F(Damage, BehindTheChecksumNeverLeadsAstray) {
  std::mt19937 random(20240607);
  const std::string whole = results::encode(content_);
  int begun_anew = 0;
  for (int i = 0; i < 150; ++i) {
    std::string bytes = whole;
    const auto place = [&] {
      return std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(random);
    };
    if (i % 3 == 0)
      bytes.resize(place());
    else
      for (int flip = 0; flip <= i % 4; ++flip) bytes[place()] ^= char(1 << (random() % 8));
    const auto content = results::decode(bytes);
    if (!content) continue;
    const std::string said = resume_from(*content);
    EXPECT_FALSE(said.empty());
    if (said.find("starts from the beginning") != std::string::npos) ++begun_anew;
  }
  EXPECT_GT(begun_anew, 0);
}

}  // namespace
}  // namespace dccast::casting
