// Whole runs of a quarter slab whose deep rows are merged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::equal_except_timing;
using testing::Recorder;

/// Grows by rows of 4 mm, of which those deeper than 24 mm are merged to 8 mm.
Case merging_slab() {
  Case c = testing::small_quarter_slab();
  c.section.growth_cell = 4e-3;
  c.section.merging = {24e-3, 8e-3};
  c.schedule.casting_speed = Curve(3e-3);
  c.time.end = 14.0;
  return c;
}

std::vector<results::StepReport> reports_of(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  EXPECT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  EXPECT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);
  return recorder.reports;
}

int merged_rows(const std::vector<results::StepReport>& reports) {
  int rows = 0;
  for (const auto& r : reports) rows += r.merged_rows;
  return rows;
}

TEST(RowMerging, KeepsMassHeatAndEquilibrium) {
  const Case c = merging_slab();
  const auto reports = reports_of(c);
  EXPECT_GE(merged_rows(reports), 2);
  for (const auto& r : reports) {
    EXPECT_LE(r.merge_energy_error, 1e-13) << "t = " << r.time;
    EXPECT_LE(r.merge_mass_error, 1e-4) << "t = " << r.time;
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    if (r.merged_rows == 0) {
      EXPECT_EQ(r.merge_equilibrium_error, 0.0);
    }
    if (r.time <= 1e-9) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
  }
  EXPECT_EQ(check(c).estimate.nodes, reports.back().nodes);
}

TEST(RowMerging, ARunKilledAroundAMergingGivesTheSameBytes) {
  Case c = merging_slab();
  c.checkpoint.every_steps = 4;
  const TemporaryFolder whole;
  Recorder uninterrupted;
  ASSERT_EQ(run(c, {whole / "", false}, uninterrupted).end, RunEnd::succeeded);

  const auto merging =
      std::ranges::find_if(uninterrupted.reports, [](const auto& r) { return r.merged_rows > 0; });
  ASSERT_NE(merging, uninterrupted.reports.end());

  for (const std::int64_t after : {merging->step - 1, merging->step, merging->step + 5}) {
    const TemporaryFolder killed;
    Recorder first, second;
    first.act_after = after;
    first.die = true;
    EXPECT_THROW(run(c, {killed / "", false}, first), Recorder::Killed);
    second.before = first.reports;
    EXPECT_EQ(run(c, {killed / "", true}, second).end, RunEnd::succeeded);
    EXPECT_GT(second.resumed_from, 0);
    EXPECT_TRUE(bytes_of(killed / "results.h5") == bytes_of(whole / "results.h5")) << after;
    EXPECT_TRUE(equal_except_timing(second.reports.back(), uninterrupted.reports.back()));
  }
}

TEST(RowMerging, FramesHoldTheMeshOfTheirTime) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(merging_slab(), {folder / "", false}, recorder).end, RunEnd::succeeded);
  const results::ResultReader reader(folder / "results.h5");
  const auto history = reader.history();
  EXPECT_EQ(merged_rows(history), merged_rows(recorder.reports));
  const results::Frame last = reader.frame(reader.frames() - 1);
  EXPECT_EQ(std::int64_t(last.temperature.size()), recorder.reports.back().nodes);
  EXPECT_EQ(last.stress.size(), std::size_t(6 * last.elements()));
}

TEST(RowMerging, RefusesWhatCannotBeMerged) {
  const auto fault_of = [](const Case& c) {
    const auto faults = check(c).faults;
    return faults.empty() ? std::string() : faults.list().front().field;
  };
  Case c = merging_slab();
  c.section.merging.largest_cell = 7e-3;
  EXPECT_EQ(fault_of(c), "mesh.merged_cell");

  c = merging_slab();
  c.section.element = mesh::ElementKind::p1;
  EXPECT_EQ(fault_of(c), "mesh.merge_below");

  c = testing::small_casting(mesh::ElementKind::q1);
  c.section.merging = {0.05, 0.02};
  EXPECT_EQ(fault_of(c), "mesh.merge_below");
}

}  // namespace
}  // namespace dccast::casting
