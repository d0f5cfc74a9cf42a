#pragma once

#include "core/mechanics/constitutive.hpp"

namespace dccast::mechanics {

/// Adds the viscoplastic strain increment of a converged step, dt H(s), to one or more strain
/// arrays.
/// @param strain  (element, point) at the start of the step on entry, at its end on return [1]
template <int Dim, class... Strain>
void accumulate_viscoplastic_strain(const StepProblem<Dim>& problem,
                                    const std::vector<SymmetricTensor<Dim>>& deviator,
                                    Strain&... strain) {
  const std::size_t points = problem.forms->points();
  for (std::size_t e = 0; e < problem.kappa.size(); ++e) {
    if (problem.kappa[e] <= 0.0) continue;
    for (std::size_t i = e * points; i < (e + 1) * points; ++i) {
      const auto rate = viscoplastic_strain_rate(problem, e, deviator[i]);
      (strain[i].add(problem.dt, rate), ...);
    }
  }
}

}  // namespace dccast::mechanics
