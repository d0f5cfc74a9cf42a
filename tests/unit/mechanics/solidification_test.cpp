#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;
using ::testing::Each;

const auto molten = uniform(680.0);
// The temperature is so little below coherency that the thermal strain since then is negligible.
constexpr double just_solid = 649.0 - 1e-10;

template <class Element>
class Solidification : public ::testing::Test {
protected:
  SlabBench<Element> bench_;
  int elements() const { return bench_.slab.mesh().elements(); }
};
using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::AxisymmetricQ1,
                                  fem::BendingQuadrilateral, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(Solidification, Families);

TYPED_TEST(Solidification, LiquidStandsUnderItsOwnPressure) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  EXPECT_THAT(bench.state.solid, Each(0));
  for (int e = 0; e < this->elements(); ++e) bench.expect_metallostatic(e, 1e-7);
  for (double u : bench.state.displacement) EXPECT_EQ(u, 0.0);
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_EQ(checks.weight, 0.0) << "nothing carries it";
  EXPECT_EQ(checks.bottom_reaction, 0.0);
  EXPECT_NEAR(checks.contact_length, 0.28, 1e-14);
}

/// The lower part freezes without cooling further: the solid starts at minus the pressure.
TYPED_TEST(Solidification, SolidStartsAtMinusTheMetallostaticPressure) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  bench.step(by_height([](double y) { return y < 0.06 ? just_solid : 680.0; }));
  int solid = 0;
  for (int e = 0; e < this->elements(); ++e) {
    solid += bench.state.solid[std::size_t(e)];
    bench.expect_metallostatic(e, 2.0);
  }
  EXPECT_GT(solid, 0);
  EXPECT_LT(solid, this->elements());
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
}

/// numerics 3: the strain of the fictitious liquid is discarded at solidification. If it were kept,
/// a strain of one per cent would cause hundreds of MPa.
TYPED_TEST(Solidification, TheStrainOfTheLiquidLeavesNoStress) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  const auto& mesh = bench.slab.mesh();
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double x = mesh.point(n)[0], y = mesh.point(n)[1];
    bench.state.displacement[2 * std::size_t(n)] =
        1e-3 * std::sin(3.14159265358979 / 0.28 * x) * (1.0 + y);
    bench.state.displacement[2 * std::size_t(n) + 1] = 1e-2 * y * (1.0 + std::cos(9.0 * x));
    if (x == bench.width) bench.state.displacement[2 * std::size_t(n)] = 0.0;
  }
  const auto before = bench.state.displacement;
  bench.step(uniform(just_solid));
  EXPECT_THAT(bench.state.solid, Each(1));

  for (int e = 0; e < this->elements(); ++e) bench.expect_metallostatic(e, 20.0);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(bench.state.displacement[i], before[i], 1e-9);
  }
}

/// After solidification the solid contracts by exactly the stretch since the coherency temperature.
TYPED_TEST(Solidification, ThermalStrainCountsFromTheCoherencyTemperature) {
  Options free_side = tight(hydrostatic);
  free_side.confinement = false;
  SlabBench<TypeParam> bench(free_side);
  bench.start(molten);
  bench.step(uniform(just_solid));
  bench.step(uniform(600.0), 1e-9);
  const material::MechanicalProperties paper(material::testing::paper_card());
  // Free in its plane, held across it: strain (1 + nu) times the thermal one. A billet is free.
  const double freedom = fem::is_axisymmetric<TypeParam> ? 1.0 : 1.0 + 0.45;
  const double exact = freedom * (paper.thermal_stretch(600.0) - 1.0) * bench.width;
  // The weight adds some kilopascals over 40 GPa.
  EXPECT_NEAR(bench.across(bench.slab.cells_per_row()), exact, 1e-5 * std::abs(exact));
}

/// The paper's alloy with a cold shell that is rigid beside what has just frozen; no creep.
material::AlloyCard rigid_shell_card() {
  material::AlloyCard card = material::testing::paper_card();
  card.young_modulus = {Abscissa::temperature, {610, 630}, {1e15, 1e10}};
  card.poisson_ratio = {Abscissa::temperature, {0, 700}, {0.3, 0.3}};
  return card;
}

/// A shell below melt cools; the melt freezes after `theta` of the time [1].
SlabBench<fem::BendingQuadrilateral>::Field freezing_over_a_shell(double theta, double time) {
  return [=](double, double y) {
    return y < 0.06 ? 500.0 - 10.0 * time : 649.0 + 10.0 * (theta - time);
  };
}

/// Stress across the slab at its middle plane in its top row [Pa], after a unit of time in equal
/// steps.
double stress_over_a_shell(double theta, int steps, bool from_the_start_of_the_step) {
  Options free_side = tight(1e-9);
  free_side.confinement = false;
  SlabBench<fem::BendingQuadrilateral> bench(free_side, rigid_shell_card());
  bench.start(freezing_over_a_shell(theta, 0.0));

  constexpr double instant = 1e-30;  // [s] in which nothing creeps
  for (int i = 0; i < steps; ++i) {
    const auto at = [&](int step) { return freezing_over_a_shell(theta, double(step) / steps); };
    if (from_the_start_of_the_step)
      bench.step(at(i + 1), instant);
    else
      bench.step_between(at(i), at(i + 1), instant);
  }
  const std::size_t e = std::size_t(bench.slab.elements_per_row() * (bench.slab.rows() - 1));
  const std::size_t point = e * bench.mechanics.points();
  return bench.state.deviator[point][0] + bench.state.pressure[point];
}

/// Metal on a rigid shell that contracts takes on the strain of the shell since its own
/// solidification, and no more: exact in any number of steps, wherever they end.
TEST(BirthWithinAStep, StrainCountsFromTheMomentOfSolidification) {
  const material::MechanicalProperties metal(rigid_shell_card());
  constexpr double young = 1e10, poisson = 0.3;
  for (const double theta : {0.1, 0.5, 0.77, 0.95}) {
    // The shell is free across the slab and held along it; the metal on it is held by both.
    const double shell = metal.thermal_stretch(490.0) - metal.thermal_stretch(500.0 - 10.0 * theta);
    const double own =
        metal.thermal_stretch(649.0 - 10.0 * (1.0 - theta)) - metal.thermal_stretch(649.0);
    const double across = (1.0 + poisson) * shell - own, along = -own;
    const double exact = young / (1.0 - poisson * poisson) * (across + poisson * along);

    for (const int steps : {1, 2, 3, 10})
      EXPECT_NEAR(stress_over_a_shell(theta, steps, false), exact, 2e-3 * std::abs(exact))
          << theta << ", " << steps << " steps";

    // The row between shell and melt contracts by a percent more and bends the shell.
    const double stiffness = young / (1.0 - poisson * poisson) * (1.0 + poisson);
    const double step = metal.thermal_stretch(490.0) - metal.thermal_stretch(500.0);
    EXPECT_NEAR(stress_over_a_shell(theta, 1, true), exact + stiffness * (step - shell),
                0.02 * stiffness * std::abs(step))
        << "from the start of the step";
  }
}

/// Stress at all points of a section through which a front of solidification rises [Pa].
std::vector<SymmetricTensor<2>> stress_behind_a_front(int steps, bool from_the_start_of_the_step) {
  const auto front = [](double time) {
    return [=](double x, double y) { return 649.0 + 800.0 * (y - 0.013 - 0.08 * time) - 20.0 * x; };
  };
  material::AlloyCard card = material::testing::paper_card();
  card.young_modulus = {Abscissa::temperature, {0, 700}, {4e10, 4e10}};
  card.poisson_ratio = {Abscissa::temperature, {0, 700}, {0.3, 0.3}};
  Options free_side = tight(1e-9);
  free_side.confinement = false;
  free_side.kinematics = Kinematics::small_strain;
  SlabBench<fem::BendingQuadrilateral> bench(free_side, card);
  bench.start(front(0.0));

  constexpr double instant = 1e-30;  // [s] in which nothing creeps
  for (int i = 0; i < steps; ++i) {
    const double before = double(i) / steps, after = double(i + 1) / steps;
    if (from_the_start_of_the_step)
      bench.step(front(after), instant);
    else
      bench.step_between(front(before), front(after), instant);
  }
  auto stress = bench.state.deviator;
  for (std::size_t i = 0; i < stress.size(); ++i) stress[i].add_identity(bench.state.pressure[i]);
  return stress;
}

TEST(BirthWithinAStep, StressConvergesWithTheStep) {
  const auto exact = stress_behind_a_front(512, false);
  const auto error = [&](int steps, bool from_the_start_of_the_step) {
    const auto stress = stress_behind_a_front(steps, from_the_start_of_the_step);
    double squares = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < stress.size(); ++i) {
      auto difference = stress[i];
      difference.add(-1.0, exact[i]);
      squares += difference.squared_norm();
      scale += exact[i].squared_norm();
    }
    return std::sqrt(squares / scale);
  };
  const double coarse = error(4, false), fine = error(64, false);
  EXPECT_LE(coarse, 0.05);
  EXPECT_LE(fine, coarse / 16.0) << "at least first order";
  EXPECT_LE(coarse, 0.2 * error(4, true));
  EXPECT_LE(fine, 0.2 * error(64, true));
}

TYPED_TEST(Solidification, MeltingAgainForgetsTheSolid) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  bench.step([](double x, double) { return 600.0 + 100.0 * x; });
  double creep = 0.0, stress = 0.0;
  for (const auto& v : bench.state.viscoplastic) creep = std::max(creep, v.norm());
  for (const auto& s : bench.state.deviator) stress = std::max(stress, s.norm());

  EXPECT_GT(stress, 1e5) << "uneven contraction";
  EXPECT_GT(creep, 0.0);

  bench.step(molten);
  EXPECT_THAT(bench.state.solid, Each(0));

  for (const auto& v : bench.state.viscoplastic) EXPECT_EQ(v.norm(), 0.0);
  for (int e = 0; e < this->elements(); ++e) bench.expect_metallostatic(e, 20.0);
}

TYPED_TEST(Solidification, TheShellOfTheStartHasNoStress) {
  auto& bench = this->bench_;
  const auto shell = [](double x, double y) {
    return std::min(680.0, 400.0 + 5000.0 * y + 200.0 * x);
  };
  bench.start(shell);
  EXPECT_TRUE(bench.state.started);
  for (const auto& s : bench.state.deviator) EXPECT_EQ(s.norm(), 0.0);
  bench.step(shell, 1e-6);
  // What is left is its weight and the liquid on it, kilopascals; the thermal strain of 250 K would
  // be a gigapascal.
  for (const auto& s : bench.state.deviator) EXPECT_LE(s.norm(), 1e5);
  for (double u : bench.state.displacement) EXPECT_LE(std::abs(u), 1e-6);
}

TYPED_TEST(Solidification, WithoutALiquidAllIsSolidFromTheStart) {
  Options options = tight(hydrostatic);
  options.liquid = Liquid::solid;
  SlabBench<TypeParam> bench(options);
  bench.start(molten);
  EXPECT_THAT(bench.state.solid, Each(1));
  bench.step(molten);
  bench.step(uniform(600.0));
  EXPECT_THAT(bench.state.solid, Each(1));
}

TYPED_TEST(Solidification, WithoutALiquidWhatIsPouredLaterIsSolidToo) {
  Options options = tight(hydrostatic);
  options.liquid = Liquid::solid;
  SlabBench<TypeParam> bench(options);
  bench.start(molten);
  bench.step(molten);
  const int per_row = this->elements() / bench.slab.rows();
  const int first_moved = this->elements() - per_row;
  bench.slab.grow_to(0.14);
  bench.mechanics.follow_growth(bench.state, bench.slab.mesh(), bench.slab.nodes_per_row(),
                                first_moved);
  bench.step(molten);

  EXPECT_THAT(bench.state.solid, Each(1));
  for (int e = 0; e < bench.slab.mesh().elements(); ++e) {
    EXPECT_LE(bench.state.pressure[std::size_t(e) * TypeParam::points], 0.0)
        << "it rests in itself";
  }
}

/// Metal that is called solid at 780 °C creeps as at its liquidus, not twelve times as fast.
TYPED_TEST(Solidification, WithoutALiquidCreepIsHeldAtTheLiquidus) {
  const auto creep_at = [](double temperature) {
    Options options = tight(hydrostatic);
    options.liquid = Liquid::solid;
    SlabBench<TypeParam> bench(options);
    bench.start(uniform(temperature));
    bench.step(uniform(temperature));
    double largest = 0.0;
    for (const auto& v : bench.state.viscoplastic) largest = std::max(largest, v.norm());
    return largest;
  };
  const double at_liquidus = creep_at(649.0);
  EXPECT_GT(at_liquidus, 0.0);
  EXPECT_NEAR(creep_at(780.0), at_liquidus, 1e-6 * at_liquidus);
}

}  // namespace
}  // namespace dccast::mechanics
