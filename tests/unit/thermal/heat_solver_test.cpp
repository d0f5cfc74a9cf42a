#include "core/thermal/heat_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

using mesh::ElementKind;
using mesh::SectionKind;
using testing::casting_alloy;
using testing::casting_cooling;
using testing::casting_section;
using testing::pure_metal;

/// Outcome of a casting with hold and growth.
struct Casting {
  HeatField field;
  double worst_balance = 0.0;
  double level = 0.0;  ///< [J/m] in through the metal level
  int most_iterations = 0;
  int iterations = 0;
  int steps = 0;
  bool converged = true;
};

Casting cast(const material::AlloyCard& alloy, const CoolingSpec& cooling, ElementKind element,
             SectionKind kind, double end, double step = 1.0) {
  mesh::SlabMesh2D slab(casting_section(element));
  HeatSolver solver(material::ThermalProperties(alloy), cooling,
                    make_heat_forms(slab.mesh(), kind));

  Casting casting;
  casting.field = solver.uniform_field(680.0);

  for (double time = -10.0; time < end - 1e-9;) {
    const double dt = time >= 0.0 && time < 2.0 ? 0.05 : step;
    time += dt;

    HeatStepInput input{.time = time,
                        .time_step = dt,
                        .metal_level = 0.10 + 1e-3 * std::max(time, 0.0),
                        .casting_temperature = 680.0,
                        .water_flow = 3e-3,
                        .bottom_gap = {},
                        .entry = {}};

    slab.grow_to(input.metal_level);
    input.entry = solver.follow_growth(casting.field, slab.nodes_per_row(), 680.0);
    const HeatStepOutcome outcome = solver.step(casting.field, input);

    casting.converged = casting.converged && outcome.converged;
    casting.worst_balance = std::max(casting.worst_balance, outcome.balance.error);
    casting.level += outcome.balance.top;
    casting.most_iterations = std::max(casting.most_iterations, outcome.iterations);
    casting.iterations += outcome.iterations;
    ++casting.steps;

    if (!outcome.converged) break;
  }
  return casting;
}

class GrowingCasting : public ::testing::TestWithParam<std::tuple<bool, ElementKind, SectionKind>> {
};

TEST_P(GrowingCasting, ConvergesAndConservesEnergyInEveryStep) {
  const auto [pure, element, kind] = GetParam();
  const Casting casting =
      cast(pure ? pure_metal() : casting_alloy(), casting_cooling(), element, kind, 60.0);
  RecordProperty("worst_balance", std::to_string(casting.worst_balance));
  EXPECT_TRUE(casting.converged);
  EXPECT_LT(casting.worst_balance, 1e-10);

  const auto [coldest, hottest] =
      std::minmax_element(casting.field.temperature.begin(), casting.field.temperature.end());
  EXPECT_GT(*coldest, 25.0);
  EXPECT_LE(*hottest, 680.0 + 1e-9);  // maximum principle
  EXPECT_LT(*coldest, 200.0);         // the water was there

  std::printf("  %d steps, %.2f iterations each, at most %d, balance %.1e\n", casting.steps,
              double(casting.iterations) / casting.steps, casting.most_iterations,
              casting.worst_balance);
}

INSTANTIATE_TEST_SUITE_P(
    Alloys, GrowingCasting,
    ::testing::Combine(::testing::Bool(), ::testing::Values(ElementKind::p1, ElementKind::q1),
                       ::testing::Values(SectionKind::plane_strain, SectionKind::axisymmetric)));

/// Heat of the metal poured in equals heat out plus heat stored, whatever happens at the level,
/// with a film that is marched down the face and a block that warms up.
TEST(HeatSolver, MetalBringsItsOwnHeatUnderEveryTop) {
  for (const Top top : {Top::pouring, Top::held, Top::insulated}) {
    CoolingSpec cooling = casting_cooling();
    cooling.top = top;
    cooling.level_coefficient = 15.0;
    cooling.water.boiling_follows_flow = true;
    cooling.water.wetting = testing::wetting();
    cooling.bottom_block.body = BlockBody{0.15, 170.0, 2.6e6, 200.0};
    const Casting casting =
        cast(casting_alloy(), cooling, ElementKind::q1, SectionKind::plane_strain, 60.0);
    EXPECT_TRUE(casting.converged);
    EXPECT_LT(casting.worst_balance, 1e-10);
    EXPECT_LE(*std::ranges::max_element(casting.field.temperature), 680.0 + 1e-9);
    // Only a held level gives heat: else no more than the metal's own comes in.
    if (top == Top::held) {
      EXPECT_GT(casting.level, 0.0);
    } else {
      EXPECT_EQ(casting.level < 0.0, top == Top::pouring);
    }
  }
}

/// A level at rest loses h (T - T_ambient) per area.
TEST(HeatSolver, TheLevelLosesHeatToTheAir) {
  CoolingSpec cooling = casting_cooling();
  cooling.zones.clear();
  cooling.water.enabled = false;
  cooling.dry_coefficient = 0.0;
  cooling.bottom_block.contact_coefficient = Curve(0.0);
  cooling.bottom_block.gap_coefficient = {};
  cooling.top = Top::pouring;
  cooling.level_coefficient = 15.0;
  const mesh::SlabMesh2D slab(casting_section(ElementKind::q1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), cooling,
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField field = solver.uniform_field(680.0);
  const HeatStepOutcome outcome =
      solver.step(field, {.time = 0.01, .time_step = 0.01, .metal_level = 0.1});

  EXPECT_NEAR(outcome.balance.top, -0.01 * 15.0 * 0.28 * (680.0 - 25.0), 0.1);
  EXPECT_NEAR(outcome.balance.top, outcome.balance.stored, 1e-6 * -outcome.balance.top);
}

/// Boiling tables fall with temperature and make the residual's derivative negative at the surface.
TEST(HeatSolver, FallingCoefficientsKeepNewtonFast) {
  CoolingSpec cooling = casting_cooling();
  cooling.water.coefficient = {
      Abscissa::temperature, {20, 100, 200, 400, 600}, {5000, 15000, 30000, 3000, 1000}};
  cooling.zones[0].solid_coefficient = Curve(4000.0);  // a solid surface cooled harder
  const Casting casting =
      cast(casting_alloy(), cooling, ElementKind::q1, SectionKind::plane_strain, 20.0);
  EXPECT_TRUE(casting.converged);
  EXPECT_LT(casting.worst_balance, 1e-10);
  EXPECT_LT(casting.iterations, 8 * casting.steps);
}

TEST(HeatSolver, WaterRunsInAStepWhoseMiddleIsAfterItsStart) {
  const mesh::SlabMesh2D slab(casting_section(ElementKind::p1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  const auto side_flux = [&](double time) {
    HeatField field = solver.uniform_field(680.0);
    return solver.step(field, {time, 1.0, 0.1, 680.0, 3e-3, {}, {}}).wall_heat_flux;
  };
  // The end of a hold, reached by a sum of steps with its rounding, is still dry.
  EXPECT_EQ(side_flux(1e-13), side_flux(0.0));
  EXPECT_GT(side_flux(1.0), 1.2 * side_flux(0.0));
}

TEST(HeatSolver, AnEdgeMovedByAPicometreChangesNothingVisible) {
  // A point test "below the water line?" jumps here: the level passes a node of the side.
  CoolingSpec moved = casting_cooling();
  moved.water.from += 1e-12;
  moved.zones[1].to += 1e-12;
  const auto run = [](const CoolingSpec& cooling) {
    return cast(casting_alloy(), cooling, ElementKind::p1, SectionKind::plane_strain, 20.0);
  };
  const Casting one = run(casting_cooling()), other = run(moved);
  double difference = 0.0;
  for (std::size_t i = 0; i < one.field.temperature.size(); ++i) {
    difference =
        std::max(difference, std::abs(one.field.temperature[i] - other.field.temperature[i]));
  }
  EXPECT_LT(difference, 1e-6);
}

TEST(HeatSolver, AStepIsAPureFunctionOfFieldAndInput) {
  mesh::SectionSpec section = casting_section(ElementKind::p1);
  const mesh::SlabMesh2D slab(section);
  HeatSolver used(material::ThermalProperties(casting_alloy()), casting_cooling(),
                  make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField field = used.uniform_field(680.0);
  const HeatStepInput first{1.0, 1.0, 0.1, 680.0, 3e-3, {}, {}};
  const HeatStepInput second{2.0, 1.0, 0.1, 680.0, 3e-3, {}, {}};
  ASSERT_TRUE(used.step(field, first).converged);

  HeatSolver fresh(material::ThermalProperties(casting_alloy()), casting_cooling(),
                   make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField resumed;
  resumed.enthalpy = field.enthalpy;
  resumed.enthalpy_rate = field.enthalpy_rate;
  ASSERT_TRUE(used.step(field, second).converged);
  ASSERT_TRUE(fresh.step(resumed, second).converged);
  EXPECT_EQ(field.enthalpy, resumed.enthalpy);
  EXPECT_EQ(field.temperature, resumed.temperature);
}

TEST(HeatSolver, TheRateOfTheStepBeforeSavesIterationsAndChangesNoTemperature) {
  const mesh::SlabMesh2D slab(casting_section(ElementKind::p1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField field = solver.uniform_field(680.0);
  int with_rate = 0, without = 0;
  for (double time = 1.0; time <= 30.0; ++time) {
    const HeatStepInput input{time, 1.0, 0.1, 680.0, 3e-3, {}, {}};
    HeatField other = field;
    other.enthalpy_rate.clear();
    without += solver.step(other, input).iterations;
    const std::vector<double> before = field.enthalpy;
    with_rate += solver.step(field, input).iterations;
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_NEAR(field.temperature[i], other.temperature[i], 1e-6);
      EXPECT_EQ(field.enthalpy_rate[i], field.enthalpy[i] - before[i]);  // the step is 1 s
    }
  }
  EXPECT_LT(with_rate, 0.9 * without) << "of " << without;
}

TEST(HeatSolver, TakesFormsThatWereInUseBefore) {
  const mesh::SlabMesh2D slab(casting_section(ElementKind::p1));
  auto forms = make_heat_forms(slab.mesh(), SectionKind::plane_strain);
  forms->update();
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    std::move(forms));
  HeatField field = solver.uniform_field(680.0);
  EXPECT_TRUE(solver.step(field, {1.0, 1.0, 0.1, 680.0, 3e-3, {}, {}}).converged);
}

TEST(HeatSolver, NonConvergenceIsAnOutcomeAndLeavesTheField) {
  const mesh::SlabMesh2D slab(casting_section(ElementKind::p1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain), 1e-11, 1);
  HeatField field = solver.uniform_field(680.0);
  const auto before = field.enthalpy;
  const HeatStepOutcome outcome = solver.step(field, {1.0, 1.0, 0.1, 680.0, 3e-3, {}, {}});
  EXPECT_FALSE(outcome.converged);
  EXPECT_EQ(outcome.iterations, 1);
  EXPECT_EQ(outcome.residual_history.size(), 2U);
  EXPECT_GT(outcome.residual_history.back(), 1e-11);
  EXPECT_EQ(field.enthalpy, before);
}

TEST(HeatSolver, InsulatedBlockWithoutCoolingStaysAsItIs) {
  CoolingSpec cooling = casting_cooling();
  cooling.top = Top::insulated;
  cooling.zones.clear();
  cooling.water.enabled = false;
  cooling.dry_coefficient = 0.0;
  cooling.bottom_block.contact_coefficient = Curve(0.0);
  const mesh::SlabMesh2D slab(casting_section(ElementKind::q1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), cooling,
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField field = solver.uniform_field(500.0);
  const HeatStepOutcome outcome = solver.step(field, {1.0, 1.0, 0.1, 680.0, 3e-3, {}, {}});
  EXPECT_TRUE(outcome.converged);

  for (const double t : field.temperature) EXPECT_NEAR(t, 500.0, 1e-9);
  EXPECT_EQ(outcome.balance.error, 0.0);
}

TEST(HeatSolver, OpenGapCoolsLess) {
  const mesh::SlabMesh2D slab(casting_section(ElementKind::p1));
  HeatSolver solver(material::ThermalProperties(casting_alloy()), casting_cooling(),
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  const auto bottom_heat = [&](const std::vector<double>& gap) {
    HeatField field = solver.uniform_field(680.0);
    HeatStepInput input{-5.0, 1.0, 0.1, 680.0, 0.0, gap, {}};
    return solver.step(field, input).balance.bottom;
  };
  const std::vector<double> open(solver.forms().bottom_nodes().size(), 1e-3);
  // The surface stays near 680 °C, so that the heat goes nearly as the coefficient, 2000 to 100.
  EXPECT_NEAR(bottom_heat(open) / (0.28 * 100.0 * 600.0), 1.0, 0.02);
  EXPECT_GT(bottom_heat({}), 15.0 * bottom_heat(open));
}

/// A slab that cools through a gap of given width on its side only: Carslaw and Jaeger,
/// section 3.11, with h = 1 / (1/2000 + 0.01 mm / 0.05 W/(m K)) = 1429 W/(m2 K), a Biot number
/// of 2.
TEST(HeatSolver, CoolsThroughAGapAsTheSeries) {
  constexpr double width = 0.28, conductivity = 200.0, capacity = 2.6e6, hot = 500.0, wall = 25.0;
  material::AlloyCard card = casting_alloy();
  card.density = Curve(2600.0);
  card.specific_heat = Curve(1000.0);
  card.conductivity = Curve(conductivity);

  CoolingSpec cooling = casting_cooling();
  cooling.top = Top::insulated;
  cooling.water.enabled = false;
  cooling.bottom_block.contact_coefficient = Curve(0.0);
  cooling.zones.resize(1);
  cooling.zones[0].to = 1.0;
  cooling.zones[0].liquid_coefficient = cooling.zones[0].solid_coefficient = Curve(2000.0);
  cooling.zones[0].gap = MouldGap{.air_conductivity = 0.05};

  const mesh::SlabMesh2D slab(casting_section(ElementKind::q1));
  HeatSolver solver(material::ThermalProperties(card), cooling,
                    make_heat_forms(slab.mesh(), SectionKind::plane_strain));
  HeatField field = solver.uniform_field(hot);
  const std::vector<double> inward(faces * field.enthalpy.size(), 0.01e-3);
  constexpr double step = 0.5, end = 200.0;
  HeatStepInput input{.time_step = step, .metal_level = 0.1, .casting_temperature = hot};
  input.inward = inward;
  for (int k = 1; k <= std::lround(end / step); ++k) {
    input.time = k * step;
    const HeatStepOutcome outcome = solver.step(field, input);
    ASSERT_TRUE(outcome.converged);
    ASSERT_LT(outcome.balance.error, 1e-10);
  }

  // Roots of z tan z = Bi, one in each interval from n pi to n pi + pi / 2.
  const double biot = width / conductivity / (1.0 / 2000.0 + 0.01e-3 / 0.05);
  const auto exact = [&](double x) {
    double sum = 0.0;
    for (int n = 0; n < 20; ++n) {
      double low = n * std::numbers::pi, high = low + 0.5 * std::numbers::pi;
      for (int i = 0; i < 60; ++i) {
        const double z = 0.5 * (low + high);
        (z * std::tan(z) < biot ? low : high) = z;
      }
      const double decay = std::exp(-low * low * conductivity / capacity * end / (width * width));
      sum += 4.0 * std::sin(low) / (2.0 * low + std::sin(2.0 * low)) * decay *
             std::cos(low * x / width);
    }
    return wall + (hot - wall) * sum;
  };
  for (int n = 0; n < slab.mesh().nodes(); ++n)
    EXPECT_NEAR(field.temperature[std::size_t(n)], exact(slab.mesh().point(n)[0]), 0.5);
}

}  // namespace
}  // namespace dccast::thermal
