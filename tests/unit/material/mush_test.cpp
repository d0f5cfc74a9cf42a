#include <gtest/gtest.h>

#include <cmath>

#include "core/material/mechanical_properties.hpp"
#include "core/material/thermal_properties.hpp"
#include "tests/unit/material/mush_card.hpp"

namespace dccast::material {
namespace {

const AlloyCard card = testing::mush_card();
const MechanicalProperties mush(card);
constexpr double coherency = 622.9, coalescence = 620.58;  // 90 and 98 % solid [°C]

/// The paper's metal coherent at its solidus has no mush: the laws must not change it by a bit.
TEST(Mush, NothingChangesForMetalThatIsCoherentAtItsSolidus) {
  AlloyCard with = testing::mush_card(), without = testing::paper_card();
  with.coherency = without.coherency = without.solidus;
  const MechanicalProperties a(with), b(without);

  for (const double t : {20.0, 300.0, 555.5, 619.999, 620.0}) {
    EXPECT_EQ(a.thermal_stretch(t), b.thermal_stretch(t)) << t;
    EXPECT_EQ(a.creep_factors(t).deviatoric, b.creep_factors(t).deviatoric) << t;
    EXPECT_EQ(a.creep_factors(t).volumetric, 0.0) << t;
  }
}

/// A free bar contracts by the integral of psi alpha_solid; alpha_solid is 2.9e-5 /K.
TEST(Mush, ContractionIsTheIntegralOfTheBridgedShare) {
  const double whole = mush.thermal_stretch(coherency) - mush.thermal_stretch(coalescence);
  const double of_solid = 0.5 * 2.9e-5 * (coherency - coalescence);  // psi is linear here
  EXPECT_NEAR(whole, of_solid, 0.05 * of_solid);

  double sum = 0.0;
  constexpr int parts = 20000;
  const double step = (coherency - coalescence) / parts;
  const double liquid_length = std::cbrt(card.density(card.liquidus));
  for (int i = 0; i < parts; ++i) {
    const double t = coalescence + (i + 0.5) * step;
    const double density = 2700.0 - 0.23 * t;  // of the solid alone
    sum +=
        mush.bridged_share(t) * liquid_length * std::pow(density, -4.0 / 3.0) * 0.23 / 3.0 * step;
  }
  EXPECT_NEAR(whole, sum, 1e-4 * sum);
}

TEST(Mush, MetalAboveCoherencyDoesNotContract) {
  EXPECT_EQ(mush.thermal_stretch(649.0), mush.thermal_stretch(coherency));
}

/// The mixture loses 2.6 % of its length on freezing; the skeleton loses a hundredth of that.
TEST(Mush, ShrinkageOfFreezingMeltDoesNotPullOnTheSkeleton) {
  AlloyCard mixture = testing::paper_card();
  mixture.coherency = coherency;
  const MechanicalProperties paper(mixture);
  const auto strain = [](const MechanicalProperties& p) {
    return p.thermal_stretch(coherency) - p.thermal_stretch(620.0);
  };
  EXPECT_GT(strain(paper), 0.002);
  EXPECT_LT(strain(mush), 0.0001);
}

TEST(Mush, UnfedShrinkageBecomesPoresOrStrain) {
  AlloyCard pulled = testing::mush_card();
  pulled.mush->unfed_strain_share = 1.0;
  const MechanicalProperties strained(pulled);

  // 2 % of the melt are left at coalescence.
  const double pores = mush.pore_share(20.0);
  EXPECT_NEAR(pores, 0.02 * std::log(2557.4 / 2360.0), 0.1 * pores);
  EXPECT_EQ(mush.pore_share(coherency), 0.0);
  EXPECT_EQ(strained.pore_share(20.0), 0.0);

  const double extra = mush.thermal_stretch(500.0) - strained.thermal_stretch(500.0);
  EXPECT_NEAR(extra, pores / 3.0, 1e-12);
}

TEST(Mush, StrengthFallsToNearlyNothingAtCoherencyAndMeetsTheSolid) {
  EXPECT_EQ(mush.relative_strength(620.0), 1.0);
  EXPECT_NEAR(mush.relative_strength(coalescence), std::exp(-0.2), 1e-9);
  EXPECT_EQ(mush.relative_strength(coherency), 1e-2);
  double before = 1.0;
  for (double t = 620.0; t < coherency; t += 0.1) {
    EXPECT_LE(mush.relative_strength(t), before);
    before = mush.relative_strength(t);
  }

  // Stress at a given rate is proportional to the strength.
  const double t = 621.5, n = 5.0;
  const double ratio = mush.creep_factors(t).deviatoric / mush.creep().kappa(t);
  EXPECT_NEAR(std::pow(ratio, -1.0 / n), mush.relative_strength(t), 1e-12);
}

/// Hollow sphere of the creeping metal under an outer tension, integrated over its wall.
TEST(Mush, PorousRatioIsThatOfAHollowSphere) {
  for (const double n : {1.0, 3.0, 5.0}) {
    for (const double porosity : {0.02, 0.1, 0.4}) {
      const double rate = 1.0;  // of dilatation, with K = 1
      const double inner = std::cbrt(porosity);
      double pressure = 0.0;
      constexpr int parts = 20000;
      for (int i = 0; i < parts; ++i) {
        const double r = inner + (1.0 - inner) * (i + 0.5) / parts;
        const double equivalent_rate = 2.0 / 3.0 * rate / (r * r * r);
        pressure += 2.0 / r * std::pow(equivalent_rate, 1.0 / n) * (1.0 - inner) / parts;
      }
      const double kappa = std::pow(1.5, 0.5 * (n + 1.0));
      EXPECT_NEAR(kappa * porous_ratio(porosity, n) * std::pow(pressure, n), rate, 1e-5)
          << n << ", " << porosity;
    }
  }
  EXPECT_EQ(porous_ratio(0.0, 5.0), 0.0);
}

TEST(Mush, VolumeCreepsWhereMeltCanMove) {
  EXPECT_GT(mush.creep_factors(622.0).volumetric, 0.0);
  EXPECT_EQ(mush.creep_factors(coalescence).volumetric, 0.0);
  EXPECT_EQ(mush.creep_factors(500.0).volumetric, 0.0);
}

/// The equation of the return map with a second stress holds, and without that stress it is the
/// power law.
TEST(Mush, AStressBesideThePressureMakesItsCreepLinear) {
  constexpr double creep = 3e-25, exponent = 6.0;
  for (const double trial : {0.0, 1e3, 2e6, 4e8}) {
    for (const double second : {0.0, 1e4, 1e6, 1e8}) {
      const double x = return_map(trial, creep, exponent, second).norm;
      const double rate = creep * std::pow(x * x + second * second, 2.0);
      EXPECT_NEAR(x * (1.0 + rate), trial, 1e-12 * trial) << trial << ", " << second;
    }
    EXPECT_EQ(return_map(trial, creep, exponent, 0.0).norm,
              return_map(trial, creep, exponent).norm);
  }
}

/// The yield limit at several points at once: equation, closed solution, derivative.
class Yield : public ::testing::Test {
protected:
  static constexpr double limit = 80e6, shear = 2.5e10;
  const double per_stress = std::sqrt(2.0 / 3.0) / (2.0 * shear);

  ReturnMaps<2> norm(double trial, double hardening, double strain) const {
    const Lanes<2> r{trial, trial}, one{1.0, 1.0};
    return limit_by_yield<2>({r, one}, r, Lanes<2>{limit, limit}, Lanes<2>{hardening, hardening},
                             Lanes<2>{strain, strain}, Lanes<2>{per_stress, per_stress});
  }
};

TEST_F(Yield, BelowTheLimitCreepDecides) {
  EXPECT_EQ(norm(0.99 * limit, 1.0, 0.0).norm[0], 0.99 * limit);
  EXPECT_EQ(norm(0.99 * limit, 1.0, 0.0).derivative[1], 1.0);
}

TEST_F(Yield, WithoutHardeningTheLimitHolds) {
  const auto map = norm(5.0 * limit, 0.0, 0.0);
  EXPECT_DOUBLE_EQ(map.norm[0], limit);
  EXPECT_EQ(map.derivative[0], 0.0);
}

TEST_F(Yield, HardenedStressIsThatOfTheStrainReached) {
  for (const double strain : {0.0, 1e-3, 0.05}) {
    for (const double trial : {3.0 * limit, 30.0 * limit, 300.0 * limit}) {
      const double x = norm(trial, 0.8, strain).norm[0];
      const double reached = strain + per_stress * (trial - x);
      const double yield = limit * (1.0 + 0.8 * (std::pow(1.0 + reached / 2e-3, 0.25) - 1.0));
      EXPECT_NEAR(x, std::min(trial, yield), 1e-9 * limit) << strain << ", " << trial;

      const double h = 1e-6 * trial;
      const double difference =
          (norm(trial + h, 0.8, strain).norm[0] - norm(trial - h, 0.8, strain).norm[0]) / (2.0 * h);
      EXPECT_NEAR(norm(trial, 0.8, strain).derivative[0], difference, 1e-6);
    }
  }
}

}  // namespace
}  // namespace dccast::material
