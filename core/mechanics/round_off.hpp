#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Size of the round-off error in a nodal force [N/m in 2D, N in 3D].
///
/// The stress-free strains, thermal and inelastic, cancel against those of the displacement; the
/// cancellation loses this much. For a body without stress and weight it is the only force scale
/// there is.
template <int Dim>
double round_off_force(const StepProblem<Dim>& problem) {
  constexpr double operations = 16.0;  // [1] roundings on the way from a strain to its nodal force
  const std::size_t points = problem.forms->points();
  std::vector<double> stress(problem.bulk.size());  // (element) stress that cancels [Pa]
  for (std::size_t e = 0; e < stress.size(); ++e) {
    double strain = 3.0 * std::abs(problem.thermal[e]);
    for (std::size_t q = 0; q < points; ++q) {
      strain = std::max(strain, problem.inelastic[e * points + q].norm());
    }
    stress[e] = (problem.bulk[e] + 2.0 * problem.shear[e]) * strain;
  }
  return operations * std::numeric_limits<double>::epsilon() *
         std::sqrt(problem.forms->squared_forces(stress));
}

/// Smallest force against which a residual is judged [N/m in 2D, N in 3D]: the weight or other
/// applied forces; if there are none, the force with which a residual of round-off size passes the
/// tolerance.
/// @param round_off  round_off_force() of the problem [N/m in 2D, N in 3D]
/// @param tolerance  of the relative residual [1]
template <int Dim>
double least_acting_force(const StepProblem<Dim>& problem, double round_off, double tolerance) {
  double applied = 0.0;
  for (const double f : problem.external_force) applied += f * f;
  return std::max({problem.weight, std::sqrt(applied), round_off / tolerance,
                   std::numeric_limits<double>::min()});
}

}  // namespace dccast::mechanics
