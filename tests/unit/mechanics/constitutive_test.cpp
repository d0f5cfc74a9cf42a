#include "core/mechanics/constitutive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace dccast::mechanics {
namespace {

using Tensor = SymmetricTensor<2>;
using Problem = StepProblem<2>;

/// One element of hot aluminium; `strength` = c R^(q-2) says how much of the trial stress creeps
/// away.
Problem one_point(double exponent, double kappa) {
  Problem problem;
  problem.dt = 0.5;
  problem.exponent = exponent;
  problem.shear = {1.38e10};
  problem.kappa = {kappa};
  return problem;
}

/// Answer of the law at one point that is alone in its block.
PointResponse<2> respond(const Problem& problem, const Tensor& trial) {
  std::vector<double> strain(4 * elements_in_block), numbers(6 * elements_in_block);
  const TensorBlock<2> strains(strain.data(), elements_in_block);
  const ResponseBlock<2> responses(numbers.data(), elements_in_block);
  strains.set(0, trial);
  return_map_law(problem)(ElementBlock{0, 1}, strains, responses);
  return responses.at(0);
}

double contraction(const Tensor& a, const Tensor& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < Tensor::components; ++i) sum += (i < 3 ? 1.0 : 2.0) * a[i] * b[i];
  return sum;
}

/// d s along `direction` by the consistent tangent 2 shear I + softening s (x) s.
Tensor by_tangent(const PointResponse<2>& response, const Tensor& direction) {
  Tensor change;
  change.add(2.0 * response.shear, direction);
  change.add(response.softening * contraction(response.deviator, direction), response.deviator);
  return change;
}

Tensor by_differences(const Problem& problem, const Tensor& trial, const Tensor& direction,
                      double h) {
  Tensor ahead = trial, behind = trial;
  ahead.add(h, direction), behind.add(-h, direction);
  Tensor change = respond(problem, ahead).deviator;
  change.add(-1.0, respond(problem, behind).deviator);
  for (double& c : change.value) c /= 2.0 * h;
  return change;
}

double error_of(const Problem& problem, const Tensor& trial, const Tensor& direction, double h) {
  Tensor d = by_differences(problem, trial, direction, h);
  const Tensor tangent = by_tangent(respond(problem, trial), direction);
  return d.add(-1.0, tangent).norm() / tangent.norm();
}

const Tensor trial = Tensor{{2e-3, -5e-4, 0.0, 1.1e-3}}.deviator();
const Tensor directions[] = {Tensor{{1.0, -1.0, 0.0, 0.0}}, Tensor{{0.0, 0.0, 0.0, 1.0}},
                             Tensor{{1.0, 1.0, -2.0, 0.3}}, trial};

/// kappa such that c R^(q-2) has the value asked for at the trial strain.
double kappa_for(double strength, double exponent) {
  const double norm = 2.0 * 1.38e10 * trial.norm();
  return strength / (2.0 * 1.38e10 * 0.5 * std::pow(norm, exponent - 2.0));
}

class Tangent : public ::testing::TestWithParam<std::tuple<double, double>> {};

/// Central differences: half the step, a quarter of the error.
TEST_P(Tangent, MeetsDifferencesAtTheExpectedOrder) {
  const auto [exponent, strength] = GetParam();
  const Problem problem = one_point(exponent, kappa_for(strength, exponent));
  for (Tensor direction : directions) {
    for (double& d : direction.value) d *= trial.norm() / direction.norm();
    const double coarse = error_of(problem, trial, direction, 0.02);
    const double fine = error_of(problem, trial, direction, 0.01);
    EXPECT_LE(fine, 1e-2);
    EXPECT_NEAR(coarse / fine, 4.0, 0.1) << "q " << exponent << " strength " << strength;
    EXPECT_LE(error_of(problem, trial, direction, 1e-5), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(FromWeakToStrongCreep, Tangent,
                         ::testing::Combine(::testing::Values(3.0, 4.7, 6.0),
                                            ::testing::Values(1e-2, 1.0, 1e3, 1e8)));

/// The same where the metal yields, ideally or with hardening, beside weak and strong creep.
TEST(ConstitutiveLaw, TangentOfYieldingMetalMeetsDifferences) {
  for (const double hardening : {0.0, 1.0}) {
    for (const double strength : {1e-6, 1e-2}) {
      Problem problem = one_point(6.0, kappa_for(strength, 6.0));
      problem.yield = {0.3 * 2.0 * 1.38e10 * trial.norm()};
      problem.hardening = {hardening};
      problem.hardened = {1e-3};
      ASSERT_LT(respond(problem, trial).deviator.norm(), 0.9 * 2.0 * 1.38e10 * trial.norm());
      for (Tensor direction : directions) {
        for (double& d : direction.value) d *= trial.norm() / direction.norm();
        const Tensor tangent = by_tangent(respond(problem, trial), direction);
        // Relative to the elastic tangent: an ideally yielding one is zero along the stress.
        const auto error = [&](double h) {
          Tensor difference = by_differences(problem, trial, direction, h);
          return difference.add(-1.0, tangent).norm() / (2.0 * 1.38e10 * direction.norm());
        };
        EXPECT_LE(error(1e-5), 1e-8) << hardening;
        if (error(0.02) <= 1e-9) continue;  // exact along the stress itself
        EXPECT_NEAR(error(0.02) / error(0.01), 4.0, 0.2) << hardening;
      }
    }
  }
}

TEST(ConstitutiveLaw, WithoutCreepIsLinear) {
  for (double kappa : {0.0, 1e-60}) {
    const Problem problem = one_point(6.0, kappa);
    const auto response = respond(problem, trial);
    EXPECT_EQ(response.shear, 1.38e10);
    EXPECT_NEAR(response.softening * response.deviator.squared_norm(), 0.0, 1e-3);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_DOUBLE_EQ(response.deviator[i], 2.0 * 1.38e10 * trial[i]);
    }
    for (const Tensor& direction : directions) {
      EXPECT_LE(error_of(problem, trial, direction, 1e-3), 1e-12);
    }
  }
}

/// Norton's law has no elastic limit, but its rate vanishes faster than the stress.
TEST(ConstitutiveLaw, NearZeroStressTheTangentIsElastic) {
  const Problem problem = one_point(6.0, kappa_for(1e3, 6.0));
  for (double scale : {0.0, 1e-30, 1e-12, 1e-6}) {
    Tensor small;
    small.add(scale, trial);
    const auto response = respond(problem, small);
    EXPECT_NEAR(response.shear, 1.38e10, 1e-6);
    for (const Tensor& direction : directions) {
      const Tensor change = by_tangent(response, direction);
      Tensor elastic;
      elastic.add(2.0 * 1.38e10, direction);
      EXPECT_LE(elastic.add(-1.0, change).norm(), 1e-12 * change.norm());
      EXPECT_LE(error_of(problem, small, direction, 1e-9), 1e-6) << scale;
    }
  }
}

/// s + 2 mu dt H(s) = 2 mu e, with the rate the law itself reports.
TEST(ConstitutiveLaw, StressAndRateSatisfyTheStepsEquation) {
  for (double strength : {1e-12, 1e-2, 1.0, 1e3, 1e12}) {
    const Problem problem = one_point(6.0, kappa_for(strength, 6.0));
    const auto response = respond(problem, trial);
    Tensor sum = response.deviator;
    sum.add(2.0 * 1.38e10 * problem.dt, viscoplastic_strain_rate(problem, 0, response.deviator));
    sum.add(-2.0 * 1.38e10, trial);
    EXPECT_LE(sum.norm(), 1e-14 * 2.0 * 1.38e10 * trial.norm()) << strength;
  }
}

/// Neighbours in a block differ in stress, modulus and creep by orders of magnitude.
TEST(ConstitutiveLaw, EveryPointOfABlockGetsItsOwnAnswer) {
  constexpr std::size_t elements = 11, points = 2, places = points * elements_in_block;

  Problem all;
  all.dt = 0.5;
  all.exponent = 6.0;
  std::vector<double> strain(4 * places), numbers(6 * places);
  const TensorBlock<2> strains(strain.data(), places);
  const ResponseBlock<2> responses(numbers.data(), places);

  // Stresses over twenty powers of ten, one of them zero.
  const auto trial_at = [](std::size_t e, std::size_t q) {
    Tensor own;
    return own.add(e == 4 ? 0.0 : std::pow(10.0, double(q) - double(e)), trial);
  };
  for (std::size_t e = 0; e < elements; ++e) {
    all.shear.push_back(1.38e10 / double(e + 1));
    all.kappa.push_back(e % 3 == 0 ? 0.0 : kappa_for(std::pow(10.0, 2.0 * double(e)), 6.0));
    for (std::size_t q = 0; q < points; ++q) strains.set(place_in_block(e, q), trial_at(e, q));
  }

  return_map_law(all)(ElementBlock{0, elements}, strains, responses);

  // Each point agrees with the law evaluated by itself.
  for (std::size_t e = 0; e < elements; ++e) {
    for (std::size_t q = 0; q < points; ++q) {
      const Tensor own = trial_at(e, q);
      const double R = 2.0 * all.shear[e] * own.norm();
      const auto map = material::return_map(R, 2.0 * all.shear[e] * all.dt * all.kappa[e], 6.0);
      const auto response = responses.at(place_in_block(e, q));

      EXPECT_NEAR(response.deviator.norm(), map.norm, 4e-15 * map.norm) << e;
      const double ratio = R > 0.0 ? map.norm / R : 1.0;
      EXPECT_NEAR(response.shear, all.shear[e] * ratio, 4e-15 * all.shear[e]) << e;

      const double slope =
          2.0 * response.shear + response.softening * response.deviator.squared_norm();
      EXPECT_NEAR(slope, 2.0 * all.shear[e] * map.derivative, 1e-13 * all.shear[e]) << e;
    }
  }
}

}  // namespace
}  // namespace dccast::mechanics
