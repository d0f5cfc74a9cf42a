// Castings over a block with a bowl, which the metal fills.
#include <gtest/gtest.h>

#include <cmath>

#include "core/casting/slab_run.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::Recorder;

Case section_over_bowl() {
  Case c = testing::small_casting(mesh::ElementKind::q1_bending);
  c.section.columns = 14;
  c.section.bowl = {.depth = 0.03, .lip = 0.04, .wall = 0.12};
  c.time.step = {Abscissa::time, {-10.0, 0.0}, {1.0, 0.5}};
  return c;
}

Case quarter_over_bowl() {
  Case c = testing::small_quarter_slab();
  c.section.bowl = {.depth = 0.02, .lip = 0.02, .wall = 0.08};
  return c;
}

/// Heat in equals heat out, and the block carries the slab through its oblique wall, too.
void expect_sound(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  const auto outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);

  for (const auto& r : recorder.reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    if (r.weight <= 0.0) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance) << "t = " << r.time;
    EXPECT_LE(r.complementarity_error, 1e-3) << "t = " << r.time;
  }
}

TEST(Bowl, EveryStepOfASectionPassesItsChecks) {
  expect_sound(section_over_bowl());
}

TEST(Bowl, EveryStepOfABilletPassesItsChecks) {
  Case c = section_over_bowl();
  c.section.kind = mesh::SectionKind::axisymmetric;
  expect_sound(c);
}

TEST(Bowl, EveryStepOfAQuarterSlabPassesItsChecks) {
  expect_sound(quarter_over_bowl());
}

TEST(Bowl, EveryStepPassesItsChecksWhereTheHeatHasAMeshOfItsOwn) {
  Case c = quarter_over_bowl();
  c.section.heat_cells = {.per_column = 2, .per_layer = 2};
  expect_sound(c);
}

/// The slab contracts towards its middle: the metal on the wall of the bowl leaves the block.
TEST(Bowl, WallOfTheBowlLosesContactAsTheSlabContracts) {
  const TemporaryFolder folder;
  Recorder recorder;
  const Case c = section_over_bowl();
  ASSERT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);
  const results::ResultReader reader(folder / "results.h5");
  const results::Frame last = reader.frame(reader.frames() - 1);

  for (std::size_t i = 0; i < last.bottom_node.size(); ++i) {
    const std::size_t n = std::size_t(last.bottom_node[i]);
    const double inward = c.section.half_width - last.node[2 * n];
    EXPECT_NEAR(last.node[2 * n + 1], -c.section.bowl->depth_at(inward), 1e-12);
    EXPECT_GE(last.bottom_gap[i], 0.0);

    // On the slope the gap is that of the vertical and the inward motion together.
    if (inward < 0.08 || inward > 0.12 || last.bottom_gap[i] <= 0.0) continue;
    const double slope = 0.5 * c.section.bowl->depth * M_PI / c.section.bowl->wall *
                         std::sin(M_PI * (inward - c.section.bowl->lip) / c.section.bowl->wall);
    const double across = last.displacement[2 * n], rise = last.displacement[2 * n + 1];
    EXPECT_NEAR(last.bottom_gap[i], (rise - slope * across) / std::hypot(1.0, slope),
                0.02 * last.bottom_gap[i] + 1e-6);
  }
}

TEST(Bowl, ShellIsMeasuredFromItsSurface) {
  Case c = section_over_bowl();
  const TemporaryFolder folder, flat_folder;
  Recorder recorder, flat;
  ASSERT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);
  c.section.bowl.reset();
  ASSERT_EQ(run(c, {flat_folder / "", false}, flat).end, RunEnd::succeeded);

  for (const auto& r : recorder.reports) EXPECT_GE(r.bottom_shell, 0.0) << "t = " << r.time;
  // The same shell grows on both, to within a cell.
  EXPECT_NEAR(recorder.reports.back().bottom_shell, flat.reports.back().bottom_shell, 0.012);
}

TEST(Bowl, ResumedCastingGivesTheSameBytes) {
  const Case c = quarter_over_bowl();
  const TemporaryFolder whole_folder, folder;
  Recorder whole, first, second;
  ASSERT_EQ(run(c, {whole_folder / "", false}, whole).end, RunEnd::succeeded);

  first.act_after = whole.reports.back().step / 2;
  first.then = Order::stop_at_checkpoint;
  ASSERT_EQ(run(c, {folder / "", false}, first).end, RunEnd::stopped);
  second.before = first.reports;
  ASSERT_EQ(run(c, {folder / "", true}, second).end, RunEnd::succeeded);
  EXPECT_TRUE(bytes_of(folder / "results.h5") == bytes_of(whole_folder / "results.h5"));
}

}  // namespace
}  // namespace dccast::casting
