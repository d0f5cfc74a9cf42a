#include "core/mechanics/constitutive.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

double contraction(const Tensor& a, const Tensor& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < Tensor::components; ++i) sum += (i < 3 ? 1.0 : 2.0) * a[i] * b[i];
  return sum;
}

/// d s along `direction` by the consistent tangent 2 shear I + normal n (x) n.
Tensor by_tangent(const PointResponse<2>& response, const Tensor& direction) {
  Tensor change;
  change.add(2.0 * response.shear, direction);
  if (response.norm > 0.0) {
    const double along = contraction(response.deviator, direction) / response.norm;
    change.add(response.normal * along / response.norm, response.deviator);
  }
  return change;
}

Tensor by_differences(const Problem& problem, const Tensor& trial, const Tensor& direction,
                      double h) {
  const auto law = return_map_law(problem);
  Tensor ahead = trial, behind = trial;
  ahead.add(h, direction), behind.add(-h, direction);
  Tensor change = law(0, 0, ahead).deviator;
  change.add(-1.0, law(0, 0, behind).deviator);
  for (double& c : change.value) c /= 2.0 * h;
  return change;
}

double error_of(const Problem& problem, const Tensor& trial, const Tensor& direction, double h) {
  Tensor d = by_differences(problem, trial, direction, h);
  const Tensor tangent = by_tangent(return_map_law(problem)(0, 0, trial), direction);
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

TEST(ConstitutiveLaw, WithoutCreepIsLinear) {
  for (double kappa : {0.0, 1e-60}) {
    const Problem problem = one_point(6.0, kappa);
    const auto response = return_map_law(problem)(0, 0, trial);
    EXPECT_EQ(response.shear, 1.38e10);
    EXPECT_NEAR(response.normal, 0.0, 1e-3);
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
    const auto response = return_map_law(problem)(0, 0, small);
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
    const auto response = return_map_law(problem)(0, 0, trial);
    EXPECT_NEAR(response.norm, response.deviator.norm(), 1e-14 * response.norm);
    Tensor sum = response.deviator;
    sum.add(2.0 * 1.38e10 * problem.dt, viscoplastic_strain_rate(problem, 0, response.deviator));
    sum.add(-2.0 * 1.38e10, trial);
    EXPECT_LE(sum.norm(), 1e-14 * 2.0 * 1.38e10 * trial.norm()) << strength;
  }
}

}  // namespace
}  // namespace dccast::mechanics
