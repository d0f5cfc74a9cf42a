#include "core/material/norton_hoff.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/unit/material/paper_card.hpp"

namespace dccast::material {
namespace {

using testing::paper_card;

/// Axial strain rate under a uniaxial stress: s_11 = 2/3 sigma, |s| = sqrt(2/3) sigma.
double uniaxial_rate(const NortonHoff& law, double stress, double temperature) {
  return law.kappa(temperature) * creep_power(std::sqrt(2.0 / 3.0) * stress, law.exponent) * 2.0 /
         3.0 * stress;
}

/// numerics 1.3: theta_0 = lambda_r / (sqrt(2) k)^q.
TEST(NortonHoff, TakesThePaperConstantsAsPrinted) {
  const NortonHoff law = norton_hoff(paper_card());
  EXPECT_NEAR(law.factor, 3.3133e-32, 0.5e-36);
  EXPECT_EQ(law.exponent, 6.0);
  EXPECT_EQ(law.zero_offset, 273.0);
  EXPECT_NEAR(law.activation_temperature, 37.3 / 1.987e-3, 1e-9);
}

/// numerics 1.3: 51 MPa at 500 °C and 1e-4 /s.
TEST(NortonHoff, ThePaperAlloyIsAsStiffAsItIs) {
  EXPECT_NEAR(uniaxial_rate(norton_hoff(paper_card()), 51e6, 500.0) / 1e-4, 1.0, 0.1);
}

TEST(NortonHoff, CreepsFasterWhenHotter) {
  const NortonHoff law = norton_hoff(paper_card());
  EXPECT_GT(law.kappa(600.0), 10.0 * law.kappa(500.0));
  EXPECT_NEAR(law.kappa(500.0), law.factor * std::exp(-37.3 / (1.987e-3 * 773.0)),
              1e-12 * law.kappa(500.0));
}

class Reference : public ::testing::TestWithParam<ReferenceCreep> {};

TEST_P(Reference, TheLawGivesBackItsTest) {
  AlloyCard card = paper_card();
  card.creep = GetParam();
  const NortonHoff law = norton_hoff(card);
  const ReferenceCreep& test = GetParam();
  const auto rate = [&](double stress, double temperature) {
    return uniaxial_rate(law, stress, temperature) / test.strain_rate;
  };

  EXPECT_NEAR(rate(test.stress, test.temperature), 1.0, 1e-13);
  EXPECT_NEAR(rate(2.0 * test.stress, test.temperature), std::pow(2.0, test.stress_exponent),
              1e-11);

  // An Arrhenius factor in absolute temperature with the gas constant 8.314462618 J/(mol K).
  const double hotter = test.temperature + 50.0;
  const double expected = test.activation_energy / 8.314462618 *
                          (1.0 / (test.temperature + 273.15) - 1.0 / (hotter + 273.15));
  EXPECT_NEAR(std::log(rate(test.stress, hotter)), expected, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Alloys, Reference,
                         ::testing::Values(ReferenceCreep{5e6, 1e-4, 500.0, 5.0, 156e3},
                                           ReferenceCreep{15e6, 1e-4, 500.0, 5.0, 156e3},
                                           ReferenceCreep{8e6, 3e-5, 450.0, 3.7, 142e3},
                                           ReferenceCreep{8e6, 3e-5, 450.0, 1.0, 0.0}),
                         [](const auto& creep) { return "number_" + std::to_string(creep.index); });

TEST(CreepPower, TheShortWayForTheExponentSixIsThePower) {
  for (double norm : {0.0, 1e-3, 1.0, 3.7, 1e3, 1.234567e7, 9.9e8}) {
    const double power = std::pow(norm, 4.0);
    EXPECT_NEAR(creep_power(norm, 6.0), power, 1e-15 * power);
  }
  EXPECT_DOUBLE_EQ(creep_power(2.0, 4.5), std::pow(2.0, 2.5));
  EXPECT_EQ(creep_power(5.0, 2.0), 1.0);
}

/// From no creep at all to creep that lets a millionth of the trial stress stand.
class Map : public ::testing::TestWithParam<double> {};

TEST_P(Map, SolvesItsEquation) {
  const double q = GetParam();
  for (double trial : {1e-6, 1.0, 3e4, 2.5e7, 6e9}) {
    for (double log_strength = -24.0; log_strength <= 6.0 * (q - 1.0); log_strength += 0.37) {
      const double creep = std::pow(10.0, log_strength) / std::pow(trial, q - 2.0);
      const ReturnMap map = return_map(trial, creep, q);
      const double residual = map.norm + creep * creep_power(map.norm, q) * map.norm - trial;
      EXPECT_LE(std::abs(residual), 1e-14 * trial)
          << "R " << trial << ", strength 1e" << log_strength;
      EXPECT_GT(map.norm, 0.0);
      EXPECT_LE(map.norm, trial);
    }
  }
}

TEST_P(Map, IsTheSameAtSeveralPointsAtOnce) {
  const double q = GetParam();
  std::array<double, most_lanes> trial{0.0, 1e-6, 1.0, 3e4, 2.5e7, 2.5e7, 6e9, 0.0};
  for (double log_strength = -24.0; log_strength <= 6.0 * (q - 1.0); log_strength += 0.37) {
    std::array<double, most_lanes> creep{}, norm, derivative;
    for (std::size_t i = 1; i < creep.size(); ++i)
      creep[i] = std::pow(10.0, log_strength) / std::pow(std::max(trial[i], 1.0), q - 2.0);
    creep[5] = 0.0;
    with_lanes([&]<int Count>() {
      for (std::size_t i = 0; i < trial.size(); i += Count) {
        const auto maps = return_maps<Count>(load<Count>(&trial[i]), load<Count>(&creep[i]), q);
        store<Count>(maps.norm, &norm[i]);
        store<Count>(maps.derivative, &derivative[i]);
      }
    });

    for (std::size_t i = 0; i < trial.size(); ++i) {
      const ReturnMap map = return_map(trial[i], creep[i], q);
      EXPECT_NEAR(norm[i], map.norm, 1e-14 * trial[i]) << "strength 1e" << log_strength;
      if (trial[i] <= 0.0) continue;
      EXPECT_NEAR(derivative[i], map.derivative, 1e-7 * map.derivative)
          << "strength 1e" << log_strength;
    }
  }
}

/// Central differences: halving their step must quarter their error.
TEST_P(Map, DerivativeMeetsDifferences) {
  const double q = GetParam();
  const double trial = 3e7;
  for (double strength : {1e-3, 0.3, 1.0, 50.0, 1e8}) {
    const double creep = strength / std::pow(trial, q - 2.0);
    const double derivative = return_map(trial, creep, q).derivative;
    const auto error = [&](double h) {
      return std::abs(
          (return_map(trial + h, creep, q).norm - return_map(trial - h, creep, q).norm) /
              (2.0 * h) -
          derivative);
    };
    EXPECT_GT(derivative, 0.0);
    EXPECT_LE(derivative, 1.0);
    if (q == 2.0) {  // linear: differences are exact
      EXPECT_LE(error(0.1 * trial), 1e-12);
    } else {
      EXPECT_NEAR(error(0.1 * trial) / error(0.05 * trial), 4.0, 0.4) << strength;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Exponents, Map, ::testing::Values(2.0, 3.0, 4.0, 4.7, 6.0, 9.0));

TEST(ReturnMap, WithoutStressOrCreepChangesNothing) {
  EXPECT_EQ(return_map(0.0, 1e-20, 6.0).norm, 0.0);
  EXPECT_EQ(return_map(0.0, 1e-20, 6.0).derivative, 1.0);
  EXPECT_EQ(return_map(4e6, 0.0, 6.0).norm, 4e6);
  EXPECT_EQ(return_map(4e6, 0.0, 6.0).derivative, 1.0);
}

}  // namespace
}  // namespace dccast::material
