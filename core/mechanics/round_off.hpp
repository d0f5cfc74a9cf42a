#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// What round-off alone may leave of a force [N/m in 2D, N in 3D].
///
/// The strains that carry no stress, thermal and inelastic, cancel against those of the displacement;
/// the stresses of what cancelled are lost at this size. A body free of stress and weight has no
/// other force by which anything could be judged.
template <class Element>
double round_off_force(const StepProblem<Element>& problem) {
  constexpr double operations = 16.0;  // roundings on the way from a strain to its nodal force
  double sum = 0.0;
  for (std::size_t e = 0; e < problem.bulk.size(); ++e) {
    double strain = 3.0 * std::abs(problem.thermal[e]);
    for (std::size_t q = 0; q < Element::points; ++q) {
      strain = std::max(strain, problem.inelastic[e * Element::points + q].norm());
    }
    const auto& cell = problem.geometry->cell(static_cast<int>(e));
    const double force = cell.volume * (problem.bulk[e] + 2.0 * problem.shear[e]) * strain;
    for (const auto& gradient : cell.mean_gradient) {
      for (const double g : gradient) sum += force * force * g * g;
    }
  }
  return operations * std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

/// The least force against which a residual is judged [N/m in 2D]: the weight or what else is applied,
/// and where nothing is what makes a residual of round-off pass the tolerance.
/// @param round_off  round_off_force() of the problem
template <class Element>
double least_acting_force(const StepProblem<Element>& problem, double round_off,
                          double tolerance) {
  double applied = 0.0;
  for (const double f : problem.external_force) applied += f * f;
  return std::max({problem.weight, std::sqrt(applied), round_off / tolerance,
                   std::numeric_limits<double>::min()});
}

}  // namespace dccast::mechanics
