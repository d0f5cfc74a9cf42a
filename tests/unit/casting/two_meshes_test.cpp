// Whole runs of a quarter slab whose heat has a mesh of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/casting/forecast.hpp"
#include "core/casting/slab_run.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;

/// With merged rows, a profile of the block and the feedback of the gap.
Case two_meshes() {
  Case c = testing::small_quarter_slab();
  c.section.heat_cells = {.per_column = 2, .per_layer = 3};
  c.section.growth_cell = 4e-3;
  c.section.merging = {24e-3, 8e-3};
  c.schedule.casting_speed = Curve(3e-3);
  c.time.end = 12.0;
  c.cooling.bottom_block.profile_x = {Abscissa::distance, {0.0, 0.28}, {0.0, 1e-3}};
  c.coupling.gap_feedback = true;
  return c;
}

TEST(TwoMeshes, EveryStepPassesItsChecks) {
  const TemporaryFolder folder;
  Recorder recorder;
  const Case c = two_meshes();
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  ASSERT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);

  int merged = 0;
  for (const auto& r : recorder.reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_LE(r.merge_energy_error, 1e-13) << "t = " << r.time;
    EXPECT_LE(r.merge_mass_error, 1e-4) << "t = " << r.time;
    merged += r.merged_rows;
    if (r.time <= 1e-9) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance);
  }
  EXPECT_GE(merged, 2);
  EXPECT_EQ(check(c).estimate.nodes, recorder.reports.back().nodes);
  EXPECT_EQ(check(c).estimate.elements, recorder.reports.back().elements);
}

/// Results are on the heat's mesh, and a pressure carried there is the same force.
TEST(TwoMeshes, AFrameHasAllFieldsOnTheHeatsMesh) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(two_meshes(), {folder / "", false}, recorder).end, RunEnd::succeeded);
  const results::ResultReader reader(folder / "results.h5");
  const results::Frame last = reader.frame(reader.frames() - 1);

  EXPECT_EQ(last.nodes(), recorder.reports.back().nodes);
  EXPECT_EQ(last.temperature.size(), std::size_t(last.nodes()));
  EXPECT_EQ(last.displacement.size(), last.node.size());
  EXPECT_EQ(last.stress.size(), std::size_t(6 * last.elements()));
  EXPECT_EQ(last.bottom_node.size(), std::size_t((4 * 2 + 1) * (3 * 3 + 1)));
  EXPECT_EQ(last.bottom_gap.size(), last.bottom_node.size());
  EXPECT_EQ(last.bottom_pressure.size(), last.bottom_node.size());

  // The corner of the metal is a node of both meshes.
  const auto& corner = recorder.reports.back().monitor_displacement.at(0);
  for (std::size_t n = 0; n < last.temperature.size(); ++n) {
    const double* x = &last.node[3 * n];
    if (std::abs(x[0] - 0.28) > 1e-9 || std::abs(x[1] - 0.14) > 1e-9 || x[2] > 1e-9) continue;
    EXPECT_NEAR(last.displacement[3 * n + 2], corner[2], 1e-12);
    EXPECT_NEAR(last.temperature[n], recorder.reports.back().monitor_temperature[0], 1e-9);
  }
}

/// The forecast computes the thickness section, whose heat has no cells of its own.
TEST(TwoMeshes, AreLeftOutOfTheForecast) {
  Case one_mesh = two_meshes();
  one_mesh.section.heat_cells = {};
  const auto codes = [](const std::vector<results::Finding>& findings) {
    std::vector<std::string> found;
    for (const results::Finding& finding : findings) found.push_back(finding.code);
    return found;
  };
  EXPECT_EQ(codes(forecast(two_meshes())), codes(forecast(one_mesh)));
}

/// Without mechanics only the heat's mesh counts, whatever cells it was divided from.
TEST(TwoMeshes, TemperaturesAreThoseOfTheHeatsMesh) {
  const auto final_temperatures = [](Case c) {
    c.mechanics.enabled = false;
    c.section.half_thickness = Curve(0.15);
    c.section.side_cell = 0.28 / c.section.columns;
    c.section.wide_side_cell = 0.15 / c.section.layers;
    c.monitors = {{"corner", 0.28, 0.15, 0.0}, {"inside", 0.13, 0.06, 0.02}};
    SlabRun<3> run(c);
    results::StepReport last;
    while (!run.finished()) last = run.advance();
    return last.monitor_temperature;
  };

  Case divided = two_meshes(), fine = two_meshes();
  fine.section.columns *= divided.section.heat_cells.per_column;
  fine.section.layers *= divided.section.heat_cells.per_layer;
  fine.section.heat_cells = {};

  const auto of_divided = final_temperatures(divided), of_fine = final_temperatures(fine);
  for (std::size_t i = 0; i < of_fine.size(); ++i) EXPECT_NEAR(of_divided[i], of_fine[i], 1e-7);
}

TEST(TwoMeshes, AKilledRunGoesOnToTheSameBytes) {
  testing::expect_the_same_bytes_after_a_kill(two_meshes());
}

TEST(TwoMeshes, ARunKilledWithARoundedCornerGoesOnToTheSameBytes) {
  Case c = testing::small_rounded_slab();
  c.section.heat_cells = {.per_column = 3, .per_layer = 2};
  testing::expect_the_same_bytes_after_a_kill(c);
}

/// A state of one mesh is not taken for that of the other.
TEST(TwoMeshes, RefuseTheStateOfOneMesh) {
  Case one = two_meshes();
  one.section.heat_cells = {};
  SlabRun<3> of_one(one), of_two(two_meshes());
  EXPECT_NE(of_two.restore(of_one.state_sections()), "");
  EXPECT_EQ(of_two.restore(of_two.state_sections()), "");
}

}  // namespace
}  // namespace dccast::casting
