#include <gmock/gmock.h>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;
using ::testing::Each;

double molten(double, double) {
  return 680.0;
}
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
  for (double u : bench.state.displacement) EXPECT_NEAR(u, 0.0, 1e-10);
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_NEAR(checks.weight, 2360.0 * 9.81 * bench.face * 0.10, 1e-9 * checks.weight);
  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-10 * checks.weight);
  EXPECT_NEAR(checks.contact_length, 0.28, 1e-14);
}

/// The lower part freezes without cooling further: the solid starts at minus the pressure.
TYPED_TEST(Solidification, SolidStartsAtMinusTheMetallostaticPressure) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  bench.step([](double, double y) { return y < 0.06 ? just_solid : 680.0; });
  int solid = 0;
  for (int e = 0; e < this->elements(); ++e) {
    solid += bench.state.solid[std::size_t(e)];
    bench.expect_metallostatic(e, 2.0);
  }
  EXPECT_GT(solid, 0);
  EXPECT_LT(solid, this->elements());
  EXPECT_LE(bench.mechanics.checks().liquid_pressure_error, 1e-3);
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
  bench.step([](double, double) { return just_solid; });
  EXPECT_THAT(bench.state.solid, Each(1));

  for (int e = 0; e < this->elements(); ++e) bench.expect_metallostatic(e, 20.0);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(bench.state.displacement[i], before[i], 1e-9);
  }
}

/// After solidification the solid contracts by exactly the stretch since the coherency temperature.
TYPED_TEST(Solidification, ThermalStrainCountsFromTheCoherencyTemperature) {
  Options free_side = balanced_to(hydrostatic);
  free_side.confinement = false;
  SlabBench<TypeParam> bench(free_side);
  bench.start(molten);
  bench.step([](double, double) { return just_solid; });
  bench.step([](double, double) { return 600.0; }, 1e-9);
  const material::MechanicalProperties paper(material::testing::paper_card());
  // Free in its plane, held across it: strain (1 + nu) times the thermal one. A billet is free.
  const double freedom = fem::is_axisymmetric<TypeParam> ? 1.0 : 1.0 + 0.45;
  const double exact = freedom * (paper.thermal_stretch(600.0) - 1.0) * bench.width;
  // The weight adds some kilopascals over 40 GPa.
  EXPECT_NEAR(bench.across(bench.slab.cells_per_row()), exact, 1e-5 * std::abs(exact));
}

TYPED_TEST(Solidification, MeltingAgainForgetsTheSolid) {
  auto& bench = this->bench_;
  bench.start(molten);
  bench.step(molten);
  bench.step([](double, double) { return 630.0; });
  double creep = 0.0, stress = 0.0;
  for (const auto& v : bench.state.viscoplastic) creep = std::max(creep, v.norm());
  for (const auto& s : bench.state.deviator) stress = std::max(stress, s.norm());

  EXPECT_GT(stress, 1e5) << "confined by the mould it cannot contract freely";
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
  Options options = balanced_to(hydrostatic);
  options.liquid = Liquid::solid;
  SlabBench<TypeParam> bench(options);
  bench.start(molten);
  EXPECT_THAT(bench.state.solid, Each(1));
  bench.step(molten);
  bench.step([](double, double) { return 600.0; });
  EXPECT_THAT(bench.state.solid, Each(1));
}

TYPED_TEST(Solidification, WithoutALiquidWhatIsPouredLaterIsSolidToo) {
  Options options = balanced_to(hydrostatic);
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
    Options options = balanced_to(hydrostatic);
    options.liquid = Liquid::solid;
    SlabBench<TypeParam> bench(options);
    const auto uniform = [=](double, double) { return temperature; };
    bench.start(uniform);
    bench.step(uniform);
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
