// Whole runs of a quarter slab solved by two grids instead of factors, as large ones are.
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>

#include "core/casting/slab_run.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::equal_except_timing;
using testing::Recorder;
using testing::small_quarter_slab;
using testing::small_rounded_slab;

Case by_two_grids(Case c) {
  c.mechanics.options.two_grids_from_unknowns = 0;
  return c;
}

std::vector<results::StepReport> reports_of(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  return recorder.reports;
}

/// Both are solved to a tenth of the tolerance: cells that have just solidified are so soft that
/// 1e-8 of the forces moves them by more than the 1e-8 m of which the answers may differ.
void expect_the_answers_of_factors(Case c) {
  c.mechanics.options.tolerance = 1e-9;
  const auto factors = reports_of(c), grids = reports_of(by_two_grids(c));
  ASSERT_EQ(factors.size(), grids.size());
  ASSERT_GT(grids.back().conjugate_gradient_iterations, 0);
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const results::StepReport &by_factor = factors[i], &found = grids[i];
    EXPECT_LE(found.equilibrium_residual, c.mechanics.options.tolerance);
    EXPECT_LE(std::abs(found.energy_balance_error), 1e-10);
    EXPECT_NEAR(found.contact_area, by_factor.contact_area, 1e-12) << "t = " << found.time;
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(found.monitor_displacement[0][std::size_t(d)],
                  by_factor.monitor_displacement[0][std::size_t(d)], 1e-8)
          << "t = " << found.time;
    }
    // A gap of 1e-8 m more or less changes what passes through it.
    EXPECT_NEAR(found.monitor_temperature[0], by_factor.monitor_temperature[0], 5e-5);
  }
}

TEST(TwoGrids, GiveTheAnswersOfFactors) {
  expect_the_answers_of_factors(small_quarter_slab());
}

TEST(TwoGrids, GiveTheAnswersOfFactorsWhereTheMouldIsRound) {
  expect_the_answers_of_factors(small_rounded_slab());
}

TEST(TwoGrids, AKilledRunGoesOnToTheSameBytes) {
  testing::expect_the_same_bytes_after_a_kill(by_two_grids(small_quarter_slab()));
}

/// Tetrahedra have no lines of cells; they keep their factor.
TEST(TwoGrids, AreNotMadeForTetrahedra) {
  Case c = small_quarter_slab(mesh::ElementKind::p1);
  const TemporaryFolder one, other;
  Recorder first, second;
  EXPECT_EQ(run(c, {one / "", false}, first).end, RunEnd::succeeded);
  EXPECT_EQ(run(by_two_grids(c), {other / "", false}, second).end, RunEnd::succeeded);
  EXPECT_TRUE(equal_except_timing(first.reports.back(), second.reports.back()));
}

/// Peak of the memory of a process that makes some steps of a case [byte].
double measured_memory(const Case& c) {
  const pid_t child = fork();
  if (child == 0) {
    SlabRun<3> steps(c);
    while (!steps.finished()) steps.advance();
    _exit(0);
  }
  int status = 1;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  EXPECT_EQ(status, 0);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// A job beyond the memory of a worker is refused by this estimate: it may not be too low.
TEST(TwoGrids, TakeTheMemoryThatIsEstimated) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer takes memory of its own";
#endif
  Case c = small_quarter_slab();
  c.section.columns = 24;
  c.section.layers = 16;
  c.section.rows = 24;
  c.section.side_cell = c.section.wide_side_cell = 8e-3;
  c.section.bottom_cell = 2e-3;
  c.schedule.hold = 0.5;
  c.time.end = 0.25;
  const double estimated = check(c).estimate.memory_bytes, measured = measured_memory(c);

  EXPECT_LE(measured, estimated);
  EXPECT_GE(measured, 0.6 * estimated);
}

}  // namespace
}  // namespace dccast::casting
