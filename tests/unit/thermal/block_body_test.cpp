#include "core/thermal/block_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/thermal/heat_solver.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

constexpr BlockBody aluminium{.thickness = 0.15, .conductivity = 170.0, .heat_capacity = 2.6e6};

std::vector<double> uniform(double temperature) {
  return std::vector<double>(BlockColumns::points, temperature);
}

TEST(BlockColumns, GainsTheHeatThatEnters) {
  BlockColumns block(aluminium);
  std::vector<double> column = uniform(25.0);
  const double before = block.heat(column);
  block.begin_step(0.5);
  for (int k = 0; k < 20; ++k) block.finish(1e5, 25.0, column);
  EXPECT_NEAR(block.heat(column) - before, 1e5 * 10.0, 1e-7 * 1e6);
}

/// The surface at the end of a step is linear in the flux that enters during it.
TEST(BlockColumns, SurfaceFollowsFromFreeSurfaceAndCompliance) {
  BlockBody cooled = aluminium;
  cooled.cooling_coefficient = 200.0;
  BlockColumns block(cooled);
  std::vector<double> column = uniform(300.0);
  column[3] = 250.0;
  block.begin_step(2.0);
  const double expected = block.free_surface(column, 25.0) + 4e5 * block.compliance();
  block.finish(4e5, 25.0, column);
  EXPECT_NEAR(column.front(), expected, 1e-10 * expected);
}

TEST(BlockColumns, EndsWithTheProfileOfASteadyFlux) {
  BlockBody cooled = aluminium;
  cooled.cooling_coefficient = 500.0;
  BlockColumns block(cooled);
  std::vector<double> column = uniform(25.0);
  block.begin_step(100.0);
  for (int k = 0; k < 2000; ++k) block.finish(5e4, 25.0, column);
  EXPECT_NEAR(column.back(), 25.0 + 5e4 / 500.0, 1e-6);
  EXPECT_NEAR(column.front() - column.back(), 5e4 * 0.15 / 170.0, 1e-6);
}

/// A half-space under a constant flux, 2 q sqrt(t / (pi k rho c)); Carslaw and Jaeger, section 2.9.
TEST(BlockColumns, MeetsTheHalfSpaceAtShortTimes) {
  BlockColumns block(aluminium);
  std::vector<double> column = uniform(0.0);
  constexpr double time = 20.0;
  block.begin_step(0.05);
  for (int k = 0; k < 400; ++k) block.finish(1e6, 0.0, column);
  const double exact = 2.0 * 1e6 * std::sqrt(time / (std::numbers::pi * 170.0 * 2.6e6));
  EXPECT_NEAR(column.front(), exact, 0.01 * exact);
}

/// Heat of the slab, of the block and through all surfaces adds up in a step of the slab.
TEST(BlockColumns, TakesTheHeatOfTheSlab) {
  CoolingSpec cooling = testing::casting_cooling();
  cooling.bottom_block.body = aluminium;
  const mesh::SlabMesh2D slab(testing::casting_section(mesh::ElementKind::q1));
  HeatSolver solver(material::ThermalProperties(testing::casting_alloy()), cooling,
                    make_heat_forms(slab.mesh(), mesh::SectionKind::plane_strain));
  HeatField field = solver.uniform_field(680.0);
  const BlockColumns block(aluminium);
  const auto block_heat = [&] {
    double sum = 0.0;
    const auto& weight = solver.forms().bottom_weight();
    for (std::size_t i = 0; i < weight.size(); ++i)
      sum += weight[i] * block.heat(std::span(field.block_temperature)
                                        .subspan(i * BlockColumns::points, BlockColumns::points));
    return sum;
  };
  double bottom = 0.0, before = 0.0;
  for (int k = 1; k <= 10; ++k) {
    HeatStepInput input;
    input.time = k;
    input.time_step = 1.0;
    input.metal_level = 0.1;
    input.casting_temperature = 680.0;
    const HeatStepOutcome outcome = solver.step(field, input);
    ASSERT_TRUE(outcome.converged);
    EXPECT_LT(outcome.balance.error, 1e-10);
    bottom += outcome.balance.bottom;
  }
  before = 80.0 * 2.6e6 * 0.15 * 0.28;

  EXPECT_NEAR(block_heat() - before, bottom, 1e-9 * bottom);
  EXPECT_GT(field.block_temperature.front(), 100.0);
}

}  // namespace
}  // namespace dccast::thermal
