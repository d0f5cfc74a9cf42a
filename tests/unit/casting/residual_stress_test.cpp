// Stresses that are left in a cold slab, and the cool-down after a cast.
#include "core/casting/findings/residual_stress.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/casting/case/casting_schedule.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "core/results/hdf5_file.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

constexpr double radius = 0.1, duration = 10.0;  // [m], [s]

/// An elastic body, solid throughout, that stands free of stress at 30 °C.
Case elastic_body(mesh::SectionKind kind) {
  Case c = small_casting(mesh::ElementKind::q1_bending);
  c.section.kind = kind;
  c.section.growth = false;
  c.alloy.young_modulus = Curve(70e9);
  c.alloy.poisson_ratio = Curve(0.33);
  c.schedule.hold = 0.0;
  c.time.step = Curve(2.5);
  c.time.end = 0.5 * duration;
  c.time.cool_down = 0.5 * duration;
  c.cooling.top = thermal::Top::insulated;
  c.mechanics.options.liquid = mechanics::Liquid::solid;
  c.mechanics.options.confinement = false;
  c.monitors.clear();
  return c;
}

/// Brings a body from 30 °C to temperatures above that. @return the report of the last step
/// @param above  of a point of the section: [K]
template <class Above>
results::StepReport heated(Case c, const Above& above) {
  const TemporaryFolder folder;
  c.thermal.file = folder / "temperature.h5";
  const mesh::SlabMesh2D slab(c.section);
  const auto nodes = std::size_t(slab.mesh().nodes());
  std::vector<double> temperature(2 * nodes, 30.0);
  for (std::size_t n = 0; n < nodes; ++n)
    temperature[nodes + n] += above(slab.mesh().point(static_cast<int>(n)));

  auto file = results::hdf5::File::create(c.thermal.file);
  file.write("/time_s", std::vector<double>{0.0, duration}, "s", "time");
  file.write("/temperature_c", {2, nodes}, temperature, "degC", "temperature");
  file.close();

  EXPECT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  Recorder recorder;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  return recorder.reports.back();
}

/// A long elastic cylinder, free of stress at one temperature, then with a parabola over its
/// radius.
/// @param rise  [K] of the axis above the face
results::StepReport cylinder_with_parabola(double rise) {
  Case c = elastic_body(mesh::SectionKind::axisymmetric);
  c.section.half_width = radius;
  c.section.initial_depth = 0.8;
  c.section.columns = 25;
  c.section.rows = 41;  // one row lies in the middle
  c.section.side_cell = 4e-3;
  c.section.bottom_cell = 0.8 / 41.0;
  c.mechanics.options.contact = false;
  c.mechanics.options.gravity = 0.0;
  return heated(c, [=](const double* point) {
    const double share = point[0] / radius;
    return rise * (1.0 - share * share);
  });
}

/// A slab whose butt is hotter than its head by a gradient that is even, so that it curls without
/// stress: in plane strain to the curvature (1 + nu) alpha dT/dz.
Case slab_on_its_block() {
  Case c = elastic_body(mesh::SectionKind::plane_strain);
  c.section.half_width = 0.4;
  c.section.initial_depth = 0.1;
  c.section.columns = 20;
  c.section.rows = 20;  // elements have one temperature, so that n rows bend by 1 / n^2 too little
  c.section.side_cell = 0.02;
  c.section.bottom_cell = 0.1 / 20.0;
  c.mechanics.options.kinematics = mechanics::Kinematics::small_strain;
  c.monitors = {{"corner", 0.4, 0.0}, {"centre", 0.0, 0.0}};
  c.output.curl = "corner";
  return c;
}

constexpr double gradient = 100.0;  // [K/m]

results::StepReport curled(const Case& c) {
  return heated(c, [](const double* point) { return gradient * (0.1 - point[1]); });
}

/// With plane sections the axial stress goes as 1 - 2 (r/R)^2 and the hoop stress as 1 - 3 (r/R)^2.
TEST(ResidualStress, OfAParabolaInACylinderChangesSignWhereItMust) {
  const results::StepReport last = cylinder_with_parabola(10.0);
  EXPECT_NEAR(1.0 - last.residual_axial_depth / radius, std::sqrt(0.5), 5e-3);
  EXPECT_NEAR(1.0 - last.residual_hoop_depth / radius, std::sqrt(1.0 / 3.0), 5e-3);
  EXPECT_GT(last.residual_tension, 0.0);

  const results::StepReport twice = cylinder_with_parabola(20.0);
  EXPECT_NEAR(twice.elastic_energy, 4.0 * last.elastic_energy, 0.02 * twice.elastic_energy);
}

/// The weight bends a curled slab back; off its block nothing does.
TEST(OffBlock, ASlabThatCurlsWithoutStressHasItsFreeShape) {
  Case c = slab_on_its_block();
  c.mechanics.options.gravity = 5000.0;
  const results::StepReport last = curled(c);

  const material::MechanicalProperties properties(c.alloy);
  const double alpha = (properties.thermal_stretch(35.0) - properties.thermal_stretch(30.0)) / 5.0;
  const double free = 0.5 * 1.33 * alpha * gradient * 0.4 * 0.4;
  const double on_block = last.monitor_displacement[0].back();
  EXPECT_LT(on_block, 0.9 * free);
  EXPECT_NEAR(last.off_block_curl, free, 0.01 * free);
  EXPECT_NEAR(last.saw_off, free, 0.01 * free);
}

/// Off its block a slab has the shape that it would have without weight, whatever it weighed.
TEST(OffBlock, TheWeightLeavesNothingBehind) {
  Case light = slab_on_its_block();
  light.mechanics.options.gravity = 1e-3;
  Case heavy = slab_on_its_block();
  heavy.mechanics.options.gravity = 5000.0;
  const double curl = curled(light).off_block_curl;
  EXPECT_GT(curl, 1e-4);
  EXPECT_NEAR(curled(heavy).off_block_curl, curl, 1e-6 * curl);
}

TEST(OffBlock, IsNotToldOfACastingThatDoesNotCoolDown) {
  Case c = slab_on_its_block();
  c.time.end = duration;
  c.time.cool_down = 0.0;
  EXPECT_EQ(curled(c).saw_off, 0.0);
}

TEST(ResidualStress, SignChangesBetweenTwoPlaces) {
  const std::vector<StressAtDepth> path{{0.01, -30e6}, {0.02, -10e6}, {0.03, 10e6}, {0.04, -1e6}};
  EXPECT_NEAR(find_sign_change(path).value(), 0.025, 1e-12);
  EXPECT_FALSE(find_sign_change(std::span(path).first(2)));
}

/// Nothing is poured and no water runs after the end of the casting; steps grow, frames stop.
TEST(CoolDown, FollowsTheCasting) {
  Case c = small_casting();
  c.time.cool_down = 3600.0;
  const CastingSchedule schedule(c);
  EXPECT_EQ(schedule.end(), 3620.0);
  EXPECT_EQ(schedule.end_of_casting(), 20.0);
  EXPECT_DOUBLE_EQ(schedule.cast_length(0.0, 0.0, 20.0), schedule.cast_length(0.0, 0.0, 3620.0));
  EXPECT_EQ(schedule.cast_length(0.02, 100.0, 10.0), 0.02);
  EXPECT_GT(schedule.water_flow(20.0, 0.02), 0.0);
  EXPECT_EQ(schedule.water_flow(21.0, 0.02), 0.0);
  EXPECT_EQ(schedule.next_frame(15.0), 20.0);
  EXPECT_EQ(schedule.next_frame(20.0), 3620.0);
  EXPECT_DOUBLE_EQ(schedule.step_at(1020.0), 20.0);
  EXPECT_LE(schedule.step_at(19.0), 1.0);
}

/// A small slab that cools down gives off all its heat above that of the air, in balance.
TEST(CoolDown, TakesTheSlabToTheTemperatureOfTheAir) {
  Case c = small_casting();
  c.cooling.top = thermal::Top::pouring;
  c.cooling.level_coefficient = 200.0;
  c.cooling.dry_coefficient = 200.0;
  c.cooling.ambient_temperature = 20.0;
  for (thermal::SideZone& zone : c.cooling.zones)
    zone.liquid_coefficient = zone.solid_coefficient = Curve(200.0);
  c.cooling.bottom_block.temperature = Curve(20.0);
  c.mechanics.enabled = false;
  c.monitors = {{"centre", 0.0, 0.05}};
  c.time.cool_down = 5e4;

  const TemporaryFolder folder;
  Recorder recorder;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  for (const auto& r : recorder.reports) EXPECT_LT(r.energy_balance_error, 1e-10) << r.time;
  EXPECT_NEAR(recorder.reports.back().monitor_temperature[0], 20.0, 1.0);
  EXPECT_LT(recorder.reports.back().time, 5e4) << "it ends when all is cold";
  EXPECT_LT(recorder.reports.size(), 700u);
}

}  // namespace
}  // namespace dccast::casting
