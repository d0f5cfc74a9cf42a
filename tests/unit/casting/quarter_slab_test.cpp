// Whole runs of a quarter slab through the driver.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/mesh/base.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::equal_except_timing;
using testing::Recorder;
using testing::small_quarter_slab;
using testing::small_rounded_slab;

class QuarterSlab : public ::testing::TestWithParam<mesh::ElementKind> {};

TEST_P(QuarterSlab, EveryStepPassesItsChecks) {
  const TemporaryFolder folder;
  Recorder recorder;
  const Case c = small_quarter_slab(GetParam());
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);

  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);

  const auto& reports = recorder.reports;
  EXPECT_EQ(check(c).estimate.steps, static_cast<std::int64_t>(reports.size()));
  EXPECT_EQ(check(c).estimate.nodes, reports.back().nodes);
  EXPECT_EQ(check(c).estimate.elements, reports.back().elements);
  EXPECT_GT(reports.back().nodes, reports.front().nodes) << "the slab has grown";
  for (const auto& r : reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_NEAR(r.side_heat + r.narrow_heat + r.bottom_heat, r.wall_heat_flux,
                0.3 * r.wall_heat_flux)
        << "at the end of the step and as its mean";
    if (r.time <= 1e-9) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance);
    EXPECT_LE(r.complementarity_error, 1e-5);
    EXPECT_GT(r.contact_area, 0.0);
    EXPECT_EQ(r.contact_length, 0.0);
  }
  // The volume below the level is 0.28 m by a mean opening of 0.14679 m.
  EXPECT_NEAR(reports.back().weight, 9.81 * 2400.0 * 0.28 * 0.14679 * 0.078,
              0.03 * reports.back().weight);
}

/// Nodes within the arc of a rounded corner and how far they have moved along its normal [m]. With
/// chords of equal angle that is the mean normal of the two at a node; not so at the ends.
std::vector<std::pair<std::size_t, double>> outward_on_arc(const mesh::SectionSpec& section,
                                                           const results::Frame& frame) {
  const auto arc = mesh::corner_arc(section);
  std::vector<std::pair<std::size_t, double>> found;
  for (std::size_t n = 0; n < frame.temperature.size(); ++n) {
    const double x = frame.node[3 * n] - arc.centre[0], y = frame.node[3 * n + 1] - arc.centre[1];
    if (x < 1e-2 || y < 1e-2 || std::abs(std::hypot(x, y) - arc.radius) > 1e-9) continue;
    const double* u = &frame.displacement[3 * n];
    found.emplace_back(n, (x * u[0] + y * u[1]) / arc.radius);
  }
  return found;
}

/// The mould holds a node of the arc along one normal; where its metal is solid it has pulled in.
TEST_P(QuarterSlab, ARoundedCornerIsHeldByItsMouldAndLetGo) {
  const TemporaryFolder folder;
  Recorder recorder;
  const Case c = small_rounded_slab(GetParam());
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);

  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  for (const auto& r : recorder.reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    if (r.time <= 1e-9) continue;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, c.mechanics.options.tolerance);
  }

  const results::ResultReader reader(folder / "results.h5");
  const results::Frame frame = reader.frame(reader.frames() - 1);
  // Triangles share the area of two chords unevenly, so that the mean normal is not quite the
  // arc's.
  const double off_the_normal = GetParam() == mesh::ElementKind::p1 ? 2e-5 : 1e-12;
  int held = 0, pulled_in = 0;
  for (const auto& [node, outward] : outward_on_arc(c.section, frame)) {
    if (frame.temperature[node] > c.alloy.solidus) {
      EXPECT_LE(outward, off_the_normal) << "node " << node;
      held += outward >= -off_the_normal ? 1 : 0;
    }
    if (outward < -1e-5) ++pulled_in;
  }
  EXPECT_GT(held, 0);
  EXPECT_GT(pulled_in, 0);
}

TEST_P(QuarterSlab, MonitorsHaveThreeCoordinatesAndATemperature) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(small_quarter_slab(GetParam()), {folder / "", false}, recorder).end,
            RunEnd::succeeded);
  for (const auto& r : recorder.reports) {
    ASSERT_EQ(r.monitor_displacement.at(1).size(), 3u);
    EXPECT_EQ(r.monitor_displacement[1][0], 0.0) << "held by the plane x = 0";
    EXPECT_EQ(r.monitor_displacement[1][1], 0.0) << "held by the plane y = 0";
    EXPECT_EQ(std::isnan(r.monitor_temperature[2]), r.cast_length < 0.004 - 1e-9) << r.time;
    EXPECT_LT(r.monitor_temperature[0], 680.0);
  }
}

TEST_P(QuarterSlab, AMeanOfMonitorsHasTheirWeightsAndNoPlace) {
  const TemporaryFolder folder;
  Recorder recorder;
  Case c = small_quarter_slab(GetParam());
  c.monitors.insert(c.monitors.begin(),
                    {.name = "plant", .of = {{"corner", 2.0}, {"centre", 1.0}}});
  c.monitors.push_back({.name = "later", .of = {{"corner", 1.0}, {"wide", 1.0}}});
  ASSERT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);

  for (const auto& r : recorder.reports) {
    for (std::size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(3.0 * r.monitor_displacement[0][d],
                  2.0 * r.monitor_displacement[1][d] + r.monitor_displacement[2][d], 1e-15);
    EXPECT_NEAR(3.0 * r.monitor_temperature[0],
                2.0 * r.monitor_temperature[1] + r.monitor_temperature[2], 1e-9);
    EXPECT_EQ(std::isnan(r.monitor_displacement[4][2]), std::isnan(r.monitor_displacement[3][2]))
        << "without one of its points there is no mean";
  }
  EXPECT_TRUE(
      std::isnan(results::ResultReader(folder / "results.h5").header().monitor_position[0][0]));
}

TEST_P(QuarterSlab, TheFileHoldsItsFramesAtTheTimesAskedFor) {
  const TemporaryFolder folder;
  Recorder recorder;
  ASSERT_EQ(run(small_quarter_slab(GetParam()), {folder / "", false}, recorder).end,
            RunEnd::succeeded);

  const results::ResultReader reader(folder / "results.h5");
  EXPECT_EQ(reader.header().section, "quarter_slab");
  EXPECT_EQ(reader.header().dimension, 3);
  EXPECT_EQ(reader.header().monitor_position.at(2), (std::vector{0.0, 0.15, 0.07}));

  const auto history = reader.history();
  ASSERT_EQ(history.size(), recorder.reports.size());
  EXPECT_EQ(history.back().monitor_displacement, recorder.reports.back().monitor_displacement);
  EXPECT_EQ(history.back().monitor_temperature, recorder.reports.back().monitor_temperature);
  EXPECT_EQ(history.back().narrow_heat, recorder.reports.back().narrow_heat);
  ASSERT_EQ(reader.frames(), 9u) << "from -3 s, every 0.7 s, and the end";
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(reader.frame(i).time, -3.0 + 0.7 * static_cast<double>(i), 1e-9);

  const results::Frame last = reader.frame(reader.frames() - 1);
  EXPECT_EQ(last.dimension, 3);
  EXPECT_EQ(last.displacement.size(), last.node.size());
  EXPECT_EQ(last.stress.size(), std::size_t(6 * last.elements()));
  EXPECT_EQ(last.bottom_pressure.size(), last.bottom_node.size());
}

TEST_P(QuarterSlab, StoppedAnywhereItGivesTheSameBytes) {
  const auto results_of = [](const std::vector<std::int64_t>& stops) {
    const TemporaryFolder folder;
    std::vector<results::StepReport> steps;
    for (std::size_t life = 0; life <= stops.size(); ++life) {
      Recorder recorder;
      recorder.before = steps;
      if (life < stops.size()) recorder.act_after = stops[life];
      recorder.then = Order::stop_at_checkpoint;
      const auto end = run(small_quarter_slab(GetParam()), {folder / "", life > 0}, recorder).end;
      EXPECT_EQ(end, life < stops.size() ? RunEnd::stopped : RunEnd::succeeded);
      EXPECT_EQ(recorder.resumed_from, life > 0 ? stops[life - 1] : -1);
      steps.insert(steps.end(), recorder.reports.begin(), recorder.reports.end());
    }
    return bytes_of(folder / "results.h5");
  };
  const std::string whole = results_of({});
  EXPECT_TRUE(results_of({5}) == whole) << "before the mechanics";
  EXPECT_TRUE(results_of({14, 16, 21}) == whole) << "before and behind a row that is put in";
}

TEST_P(QuarterSlab, AKilledRunGoesOnToTheSameBytes) {
  testing::expect_the_same_bytes_after_a_kill(small_quarter_slab(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Elements, QuarterSlab,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1,
                                           mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
