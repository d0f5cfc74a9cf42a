#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/material/mush_card.hpp"
#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;
using material::testing::mush_card;
using ::testing::Each;

const auto molten = uniform(680.0);

/// One element of mush whose volume is held: its mean stress beyond the pressure of its melt decays
/// as dp/dt = -K kappa p^5 has it.
TEST(MushMechanics, MushHeldInAllDirectionsRelaxesItsPressure) {
  constexpr double bulk = 130e9, kappa = 2e-42, melt = 2e4, start = -40e6, end = 1.0;
  const auto relaxed_in = [&](int steps) {
    StepProblem<3> problem;
    problem.exponent = 6.0;
    problem.dt = end / steps;
    problem.bulk = {bulk};
    problem.volumetric_kappa = {kappa};
    problem.melt_pressure = {melt};
    problem.linear_below = {0.0};
    double stress = start - melt;
    for (int i = 0; i < steps; ++i) stress = relaxed_mean_stress(problem, 0, stress).stress;
    return stress + melt;
  };

  const double exact = -std::pow(std::pow(-start, -4.0) + 4.0 * bulk * kappa * end, -0.25);
  ASSERT_GT(std::abs(exact - start), 0.2 * std::abs(start)) << "it must relax";
  const double error = relaxed_in(100) - exact, half = relaxed_in(200) - exact;
  EXPECT_LE(std::abs(error), 0.01 * std::abs(exact));
  EXPECT_NEAR(error / half, 2.0, 0.1) << "first order";
}

/// Below `linear_below` the pressure of held mush decays exponentially.
TEST(MushMechanics, ASmallPressureDecaysExponentially) {
  constexpr double bulk = 60e9, kappa = 3e-35, linear_below = 1e6, start = 1e3, end = 1.0;
  StepProblem<3> problem;
  problem.exponent = 6.0;
  problem.dt = end / 1000;
  problem.bulk = {bulk};
  problem.volumetric_kappa = {kappa};
  problem.melt_pressure = {0.0};
  problem.linear_below = {linear_below};

  double stress = start;
  for (int i = 0; i < 1000; ++i) stress = relaxed_mean_stress(problem, 0, stress).stress;
  const double exact = start * std::exp(-bulk * kappa * std::pow(linear_below, 4.0) * end);
  ASSERT_LT(exact, 0.5 * start) << "it must relax";
  EXPECT_NEAR(stress, exact, 3e-3 * exact);
}

/// Stress along a bar whose ends are held, by the law for one stress alone: elastic and creep
/// strain are what the bar would have contracted.
class HeldBar {
public:
  explicit HeldBar(const material::MechanicalProperties& law) : law_(law) {}

  /// @param contraction  free strain since the start [1], negative @return stress [Pa]
  double step(double temperature, double contraction, double dt) {
    const double young =
        9.0 / (1.0 / law_.bulk_modulus(temperature) + 3.0 / law_.shear_modulus(temperature));
    double low = 0.0, high = 1e9;
    for (int i = 0; i < 200; ++i) {
      stress_ = 0.5 * (low + high);
      const double strain =
          stress_ / young + crept_ + dt * creep_rate(temperature, stress_) + contraction;
      (strain > 0.0 ? high : low) = stress_;
    }
    crept_ += dt * creep_rate(temperature, stress_);
    return stress_;
  }

  /// Rate of strain along the bar at a stress along it [1/s].
  double creep_rate(double temperature, double stress) const {
    const double power = law_.creep().exponent - 2.0;
    const auto creep = law_.creep_factors(temperature);
    const double norm = std::sqrt(2.0 / 3.0) * stress, mean = stress / 3.0;
    return creep.deviatoric * std::pow(norm, power) * (2.0 / 3.0) * stress +
           creep.volumetric / 3.0 * std::pow(std::hypot(mean, creep.linear_below), power) * mean;
  }

private:
  const material::MechanicalProperties& law_;
  double stress_ = 0.0;  ///< [Pa]
  double crept_ = 0.0;   ///< [1]
};

/// A bar that is held at both ends and cools from coherency on builds the stress of its law.
TEST(MushMechanics, AHeldBarBuildsTheStrengthOfItsLaw) {
  using Element = fem::AxisymmetricQ1;
  constexpr double start = 622.9, end = 560.0, cooling = 0.05;  // [degC], [degC], [K/s]
  const material::MechanicalProperties law(mush_card());

  FixedBody<Element> bar(box<Element>({0.01, 0.05}, {1, 1}));
  bar.problem.exponent = law.creep().exponent;
  bar.problem.melt_pressure = {0.0};
  for (int n = 0; n < bar.mesh.nodes(); ++n) bar.fix(n, 1, 0.0);
  hold_low_end(bar, 0);

  HeldBar exact(law);
  constexpr int steps = 1000;
  constexpr double dt = (start - end) / cooling / steps;
  for (int i = 1; i <= steps; ++i) {
    const double temperature = start + (end - start) * i / steps;
    const auto creep = law.creep_factors(temperature);
    const double contraction = law.thermal_stretch(temperature) - law.thermal_stretch(start);
    bar.problem.bulk = {law.bulk_modulus(temperature)};
    bar.problem.shear = {law.shear_modulus(temperature)};
    bar.problem.kappa = {creep.deviatoric};
    bar.problem.volumetric_kappa = {creep.volumetric};
    bar.problem.linear_below = {creep.linear_below};
    bar.problem.thermal = {contraction};
    ASSERT_TRUE(bar.step(tight(1e-11), dt).converged) << temperature;

    const double stress = exact.step(temperature, contraction, dt);
    ASSERT_NEAR(bar.stress(0, 0)[1], stress, 1e-6 * stress + 1.0) << temperature;
  }

  // Solid by now: creep is as fast as contraction.
  const double contraction_rate =
      -cooling * (law.thermal_stretch(end - 0.5) - law.thermal_stretch(end + 0.5));
  EXPECT_NEAR(exact.creep_rate(end, bar.stress(0, 0)[1]), contraction_rate, 0.2 * contraction_rate);
}

TEST(MushMechanics, TangentOfTheMeanStressIsItsDerivative) {
  StepProblem<3> problem;
  problem.exponent = 6.0;
  problem.dt = 0.5;
  problem.bulk = {60e9};
  problem.volumetric_kappa = {1e-43};
  problem.melt_pressure = {3e4};
  for (const double linear_below : {0.0, 2e6, 300e6}) {
    problem.linear_below = {linear_below};
    for (const double trial : {-300e6, -1e6, 20e6, 500e6}) {
      const double h = 1e-5 * std::abs(trial);
      const double difference = (relaxed_mean_stress(problem, 0, trial + h).stress -
                                 relaxed_mean_stress(problem, 0, trial - h).stress) /
                                (2.0 * h);
      EXPECT_NEAR(relaxed_mean_stress(problem, 0, trial).tangent / 60e9, difference, 1e-7)
          << trial << ", " << linear_below;
    }
  }
}

template <class Element>
class MushSlab : public ::testing::Test {};
using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::AxisymmetricQ1,
                                  fem::BendingQuadrilateral, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(MushSlab, Families);

/// A free section in the mush contracts as its law says.
TYPED_TEST(MushSlab, FreeMushContractsByTheStretchOfItsSkeleton) {
  Options free_side = tight(hydrostatic);
  free_side.confinement = false;
  free_side.gravity = 0.0;
  SlabBench<TypeParam> bench(free_side, mush_card());
  bench.start(molten);
  bench.step(uniform(621.0), 1e-12);

  const material::MechanicalProperties law(mush_card());
  const double contraction = law.thermal_stretch(621.0) - law.thermal_stretch(622.9);
  // Free in its plane, held across it: 1 + nu times the strain. A billet is free.
  const double freedom = fem::is_axisymmetric<TypeParam> ? 1.0 : 1.0 + 0.45;
  const double exact = freedom * contraction * bench.width;
  ASSERT_LT(exact, 0.0);
  EXPECT_NEAR(bench.across(bench.slab.cells_per_row()), exact, 1e-3 * std::abs(exact));
}

/// Metal that cools unevenly yields, and hardens in the cold only.
TYPED_TEST(MushSlab, ColdMetalYieldsAndHardens) {
  SlabBench<TypeParam> bench(tight(1e-9), mush_card());
  bench.start(molten);
  bench.step([](double x, double) { return 450.0 + 300.0 * x; });
  EXPECT_THAT(bench.state.hardened, Each(0.0)) << "too hot to harden";

  bench.step([](double x, double) { return 150.0 + 900.0 * x; });
  const double hardest = *std::ranges::max_element(bench.state.hardened);
  EXPECT_GT(hardest, 1e-4);
  for (std::size_t i = 0; i < bench.state.deviator.size(); ++i) {
    // The coldest metal is the strongest: 100 MPa less 80 MPa times its share of 380 K.
    const double yield = 100e6 - 80e6 * 130.0 / 380.0;
    const double most = yield * std::pow(1.0 + bench.state.hardened[i] / 2e-3, 0.25);
    EXPECT_LE(bench.state.deviator[i].norm(), std::sqrt(2.0 / 3.0) * most * (1.0 + 1e-6)) << i;
  }
}

/// The strain of a first life is forgotten by remelting; kept, it would stress the metal by tens of
/// megapascals. What is left is the weight of metal that stands on the nodes that its first life
/// has left on the block.
TYPED_TEST(MushSlab, FreezingAgainStartsWithoutStrainOfTheFirstLife) {
  SlabBench<TypeParam> bench(tight(1e-9), mush_card());
  bench.start(molten);
  bench.step([](double x, double) { return 150.0 + 900.0 * x; });
  double first_life = 0.0;
  for (const auto& s : bench.state.deviator) first_life = std::max(first_life, s.norm());
  EXPECT_GT(first_life, 1e7);

  bench.step(molten);
  EXPECT_THAT(bench.state.hardened, Each(0.0));
  for (const auto& strain : bench.state.viscoplastic) EXPECT_EQ(strain.norm(), 0.0);

  bench.step(uniform(622.9 - 1e-9));
  for (int e = 0; e < bench.slab.mesh().elements(); ++e) bench.expect_metallostatic(e, 1e5);
}

}  // namespace
}  // namespace dccast::mechanics
