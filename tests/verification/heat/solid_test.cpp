// The heat solver in solids against exact solutions and against the section.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/slab_mesh.hpp"
#include "core/thermal/heat_solver.hpp"
#include "tests/support/quarter_section.hpp"
#include "tests/unit/thermal/casting_case.hpp"
#include "tests/verification/heat/heat_runs.hpp"

namespace dccast::verification {
namespace {

using mesh::ElementKind;
using thermal::CoolingSpec;
using thermal::Face;
using thermal::HeatField;
using thermal::HeatSolver;
using thermal::HeatStepInput;

/// A box of uniform cells: extent and number along x, y and z.
mesh::SectionSpec box(const std::array<double, 3>& extent, const std::array<int, 3>& cells,
                      ElementKind element) {
  mesh::SectionSpec section =
      testing::quarter_section(element, {extent[0], Curve(extent[1]), extent[2]},
                               {cells[0], cells[1], cells[2], extent[0] / cells[0],
                                extent[1] / cells[1], extent[2] / cells[2]});
  section.growth = false;
  return section;
}

/// Neumann's problem along one direction of an extruded mesh, two cells across.
class StefanAlong : public ::testing::TestWithParam<std::tuple<int, ElementKind>> {
protected:
  static constexpr double length = 0.06, cell = 0.25e-3, time_step = 0.01, end = 6.0;
  static constexpr int cells = 240;

  static mesh::SlabMesh3D bar(int axis, ElementKind element) {
    std::array<double, 3> extent{2 * cell, 2 * cell, 2 * cell};
    std::array<int, 3> number{2, 2, 2};
    extent[std::size_t(axis)] = length;
    number[std::size_t(axis)] = cells;
    return mesh::SlabMesh3D(box(extent, number, element));
  }

  /// The wall: the metal level held, or a face cooled so hard that it has the wall's temperature.
  static CoolingSpec wall_on(int axis, const StefanData& stefan) {
    CoolingSpec cooling = insulated();
    if (axis == 2) return cooling;
    cooling.top = thermal::Top::insulated;
    const Curve hard(1e3 * stefan.solid_conductivity / cell);
    thermal::SideZone zone;
    zone.to = 1.0;
    zone.liquid_coefficient = zone.solid_coefficient = hard;
    zone.temperature = Curve(stefan.wall);
    zone.face = axis == 0 ? Face::narrow : Face::wide;
    cooling.zones = {zone};
    return cooling;
  }
};

TEST_P(StefanAlong, FrontAndTemperatureAreTheExactOnes) {
  const auto [axis, element] = GetParam();
  const StefanData stefan;
  const NeumannSolution exact(stefan);
  const mesh::SlabMesh3D slab = bar(axis, element);
  HeatSolver solver(material::ThermalProperties(metal_of(stefan)), wall_on(axis, stefan),
                    thermal::make_heat_forms(slab.mesh()));

  HeatField field = solver.uniform_field(stefan.initial);
  RunSize size;
  const double level = axis == 2 ? length : 2 * cell;
  for (double time = time_step; time < end + 0.5 * time_step; time += time_step) {
    HeatStepInput input;
    input.time = time;
    input.time_step = time_step;
    input.metal_level = level;
    input.casting_temperature = stefan.wall;
    take(size, solver.step(field, input));
  }
  EXPECT_TRUE(size.converged);
  EXPECT_LT(size.worst_balance, 1e-10);

  // Depth of the solid by its share of the volume, and the temperature at 10 mm.
  const auto& volume = solver.forms().volume();
  double solid = 0.0, total = 0.0, probe = 0.0;
  int probes = 0;
  for (std::size_t n = 0; n < volume.size(); ++n) {
    solid += volume[n] * (1.0 - field.liquid_fraction[n]);
    total += volume[n];
    const double depth = length - slab.mesh().point(static_cast<int>(n))[axis];
    if (std::abs(depth - 0.010) > 1e-6) continue;
    probe += field.temperature[n];
    ++probes;
  }

  EXPECT_NEAR(solid / total * length / exact.front(end), 1.0, 0.02);
  ASSERT_EQ(probes, 9);
  EXPECT_NEAR(probe / probes, exact.temperature(0.010, end), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Directions, StefanAlong,
                         ::testing::Values(std::tuple{0, ElementKind::p1},
                                           std::tuple{0, ElementKind::q1},
                                           std::tuple{1, ElementKind::q1},
                                           std::tuple{2, ElementKind::p1}));

/// Decay of cos(pi x/a) cos(pi y/a) cos(pi z/a) in an insulated cube: second order in the cell, the
/// step going as its square.
class CubeMode : public ::testing::TestWithParam<ElementKind> {
protected:
  static double error(int cells, ElementKind element) {
    constexpr double side = 0.1, diffusivity = 1e-4, end = 3.0, mean = 300.0, amplitude = 100.0;

    material::AlloyCard card;
    card.solidus = 600.0;
    card.liquidus = 650.0;
    card.density = Curve(2500.0);
    card.specific_heat = Curve(1000.0);
    card.conductivity = Curve(diffusivity * 2500.0 * 1000.0);
    CoolingSpec cooling = insulated();
    cooling.top = thermal::Top::insulated;
    const mesh::SlabMesh3D slab(box({side, side, side}, {cells, cells, cells}, element));
    HeatSolver solver(material::ThermalProperties(card), cooling,
                      thermal::make_heat_forms(slab.mesh()));

    const auto mode = [&](std::size_t node) {
      const double* x = slab.mesh().point(static_cast<int>(node));
      double product = 1.0;
      for (int a = 0; a < 3; ++a) product *= std::cos(std::numbers::pi * x[a] / side);
      return product;
    };

    HeatField field = solver.uniform_field(mean);
    for (std::size_t n = 0; n < field.enthalpy.size(); ++n)
      field.enthalpy[n] = solver.properties().enthalpy(mean + amplitude * mode(n));

    const int steps = cells * cells;
    for (int i = 1; i <= steps; ++i) {
      HeatStepInput input;
      input.time = i * end / steps;
      input.time_step = end / steps;
      input.metal_level = side;
      EXPECT_TRUE(solver.step(field, input).converged);
    }

    // Relative error in the L2 norm against the exact decay.
    const double decay =
        std::exp(-3.0 * diffusivity * end * std::numbers::pi * std::numbers::pi / (side * side));
    double error_square = 0.0, exact_square = 0.0;
    for (std::size_t n = 0; n < field.enthalpy.size(); ++n) {
      const double exact = amplitude * decay * mode(n), volume = solver.forms().volume()[n];
      error_square += volume * std::pow(field.temperature[n] - mean - exact, 2);
      exact_square += volume * exact * exact;
    }
    return std::sqrt(error_square / exact_square);
  }
};

TEST_P(CubeMode, ConvergesWithSecondOrder) {
  const double coarse = error(4, GetParam()), fine = error(8, GetParam());
  RecordProperty("order", std::to_string(observed_order(coarse, fine)));
  EXPECT_GT(observed_order(coarse, fine), 1.8);
  EXPECT_LT(fine, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Elements, CubeMode, ::testing::Values(ElementKind::p1, ElementKind::q1));

/// A quarter slab cast until it is steady: the heat that leaves through faces and bottom equals the
/// heat of the metal that is poured minus that at the foot, plus the heat that the metal level,
/// held at its temperature, conducts in.
TEST(SteadyStrand, WallsTakeWhatTheMetalBrings) {
  constexpr double speed = 1e-3, step = 20.0, pouring = 680.0;
  mesh::SectionSpec section = box({0.66, 0.28, 0.1}, {6, 6, 5}, ElementKind::q1);
  section.side_cell = 0.02;
  section.wide_side_cell = 0.01;
  section.growth_cell = 0.02;
  section.growth = true;

  mesh::SlabMesh3D slab(section);
  HeatSolver solver(material::ThermalProperties(thermal::testing::casting_alloy()),
                    thermal::testing::casting_cooling(), thermal::make_heat_forms(slab.mesh()));

  HeatField field = solver.uniform_field(pouring);
  double out = 0.0, conducted = 0.0, duration = 0.0;
  constexpr double end = 1600.0, steady = 1200.0;
  for (double time = step; time <= end; time += step) {
    HeatStepInput input;
    input.time = time;
    input.time_step = step;
    input.metal_level = 0.1 + speed * time;
    input.casting_temperature = pouring;
    input.water_flow = 3e-3;

    slab.grow_to(input.metal_level);
    input.entry = solver.follow_growth(field, slab.nodes_per_row(), pouring);
    const auto outcome = solver.step(field, input);
    ASSERT_TRUE(outcome.converged);
    EXPECT_LT(outcome.balance.error, 1e-10);

    if (time <= steady) continue;
    out += outcome.balance.side + outcome.balance.bottom;
    conducted += outcome.balance.top;
    duration += step;
  }

  const auto& properties = solver.properties();
  double foot = 0.0;
  const auto& bottom = solver.forms().bottom_nodes();
  const auto& weight = solver.forms().bottom_weight();
  for (std::size_t i = 0; i < bottom.size(); ++i)
    foot += weight[i] * field.enthalpy[std::size_t(bottom[i])];
  const double brought = speed * (0.66 * 0.28 * properties.enthalpy(pouring) - foot);

  EXPECT_NEAR(brought / 0.66, 0.74e6, 0.01e6)
      << "the figure of the casting data, per metre of face";
  EXPECT_NEAR(out / (duration * brought + conducted), 1.0, 0.01);
  EXPECT_LT(conducted, 0.1 * out);
}

}  // namespace
}  // namespace dccast::verification
