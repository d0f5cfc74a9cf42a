// Castings over a plan from a file.
#include <gtest/gtest.h>

#include <cmath>

#include "core/casting/forecast.hpp"
#include "core/mesh/base.hpp"
#include "tests/support/drawn_plan.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::Recorder;
using testing::small_quarter_slab;

/// A small slab whose rows grow and are merged, with a bowl.
Case growing_slab() {
  Case c = small_quarter_slab();
  c.section.half_thickness = Curve(0.14);
  c.section.bowl = {.depth = 0.01, .lip = 0.02, .wall = 0.06};
  c.section.growth_cell = 4e-3;
  c.section.merging = {24e-3, 8e-3};
  c.schedule.casting_speed = Curve(3e-3);
  c.time.end = 8.0;
  c.monitors = {{"corner", 0.28, 0.14, 0.0}, {"centre", 0.0, 0.0, 0.0}};
  return c;
}

/// A quarter of a cross: an arm of 0.28 by 0.06 m, and a stem 0.12 m wide up to y = 0.14 m. No
/// opening of the built-in mesh has an inner corner.
mesh::Base<3> cross() {
  return dccast::testing::draw_plan({0, 0.06, 0.12, 0.2, 0.26, 0.28}, {0, 0.03, 0.06, 0.1, 0.14},
                                    [](double x, double y) { return x < 0.12 || y < 0.06; });
}
constexpr double area_of_cross = 0.28 * 0.06 + 0.12 * 0.08;  // [m2]

std::vector<results::StepReport> reports_of(const Case& c, const std::filesystem::path& folder) {
  EXPECT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  Recorder recorder;
  const RunOutcome outcome = run(c, {folder, false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  return recorder.reports;
}

TEST(OwnPlan, TheBuiltInPlanFromAFileGivesTheSameCurl) {
  const TemporaryFolder folder, other;
  Case c = growing_slab();
  const auto built_in = reports_of(c, folder.path());
  const Estimate estimate = check(c).estimate;

  dccast::testing::write_text(dccast::testing::gmsh_text(mesh::base_of<3>(c.section)),
                              other / "plan.msh");
  c.section.file = other / "plan.msh";
  const auto own = reports_of(c, other.path());

  ASSERT_EQ(own.size(), built_in.size());
  int merged = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_LE(std::abs(own[i].energy_balance_error), 1e-10) << "t = " << own[i].time;
    EXPECT_EQ(own[i].nodes, built_in[i].nodes);
    merged += own[i].merged_rows;
  }
  EXPECT_GT(merged, 0);

  // The bowl's depth is a distance from faces, which is found in another way: round-off.
  const double curl = built_in.back().monitor_displacement[0][2];
  EXPECT_GT(std::abs(curl), 1e-5);
  EXPECT_NEAR(own.back().monitor_displacement[0][2], curl, 1e-9 * std::abs(curl));
  EXPECT_EQ(check(c).estimate.nodes, estimate.nodes);
  EXPECT_EQ(check(c).estimate.elements, estimate.elements);
  EXPECT_EQ(check(c).estimate.solver_seconds, estimate.solver_seconds);
}

class CrossCasting : public ::testing::TestWithParam<int> {
protected:
  /// A casting of the cross, whose metal has nearly one density: one that does not fall as the
  /// metal warms up contracts nothing, and is refused. The parameter is the refinement.
  Case casting() {
    Case c = growing_slab();
    dccast::testing::write_text(dccast::testing::gmsh_text(cross()), folder_ / "cross.msh");
    c.section.file = folder_ / "cross.msh";
    c.section.refinement = GetParam();
    c.section.bowl.reset();
    c.section.merging = {};
    c.alloy.density = {Abscissa::temperature, {0.0, 700.0}, {2600.01, 2600.0}};
    c.time.end = 3.0;
    c.monitors = {{"end of the arm", 0.28, 0.06, 0.0}, {"inner corner", 0.12, 0.06, 0.01}};
    return c;
  }
  TemporaryFolder folder_;
};

TEST_P(CrossCasting, KeepsHeatAndWeight) {
  const Case c = casting();
  const auto reports = reports_of(c, folder_.path());
  ASSERT_FALSE(reports.empty());
  for (const auto& r : reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    if (r.time <= 1e-9) continue;
    const double weight = 9.81 * 2600.0 * area_of_cross * (0.066 + r.cast_length);
    EXPECT_NEAR(r.weight, weight, 1e-3 * weight) << "t = " << r.time;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
  }
  EXPECT_GT(reports.back().nodes, reports.front().nodes) << "the slab has grown";
  EXPECT_EQ(check(c).estimate.nodes, reports.back().nodes);
  EXPECT_EQ(check(c).estimate.elements, reports.back().elements);
}

INSTANTIATE_TEST_SUITE_P(Refinements, CrossCasting, ::testing::Values(1, 2));

TEST(OwnPlan, AResumedRunGivesTheSameBytes) {
  const TemporaryFolder plans;
  dccast::testing::write_text(dccast::testing::gmsh_text(cross()), plans / "cross.msh");
  Case c = growing_slab();
  c.section.file = plans / "cross.msh";
  c.section.bowl.reset();
  c.monitors = {{"inner corner", 0.12, 0.06, 0.01}};

  const TemporaryFolder whole, parts;
  const std::size_t steps = reports_of(c, whole.path()).size();
  Recorder first, second;
  first.act_after = static_cast<std::int64_t>(steps) - 6;
  first.then = Order::stop_at_checkpoint;
  ASSERT_EQ(run(c, {parts.path(), false}, first).end, RunEnd::stopped);
  second.before = first.reports;
  ASSERT_EQ(run(c, {parts.path(), true}, second).end, RunEnd::succeeded);
  EXPECT_EQ(second.resumed_from, first.act_after);
  EXPECT_TRUE(bytes_of(parts / "results.h5") == bytes_of(whole / "results.h5"));
}

/// The forecast computes the thickness in the middle of the wide face.
TEST(OwnPlan, HasTheForecastOfItsThickness) {
  const TemporaryFolder folder;
  Case c = growing_slab();
  const auto built_in = forecast(c);
  dccast::testing::write_text(dccast::testing::gmsh_text(cross()), folder / "cross.msh");
  c.section.file = folder / "cross.msh";
  const auto own = forecast(c);
  ASSERT_EQ(own.size(), built_in.size());
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(own[i].message, built_in[i].message);
}

}  // namespace
}  // namespace dccast::casting
