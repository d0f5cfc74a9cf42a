#pragma once

#include "core/mechanics/constitutive.hpp"

namespace dccast::mechanics {

/// Adds the viscoplastic strain of a converged step, dt H(s), to the strain that carries no stress.
/// @param inelastic  by point, of the start of the step; afterwards of its end
template <int Dim>
void accumulate_viscoplastic_strain(const StepProblem<Dim>& problem,
                                    const std::vector<SymmetricTensor<Dim>>& deviator,
                                    std::vector<SymmetricTensor<Dim>>& inelastic) {
  for (std::size_t i = 0; i < inelastic.size(); ++i) {
    const std::size_t e = i / problem.forms->points();
    if (problem.kappa[e] <= 0.0) continue;
    inelastic[i].add(problem.dt, viscoplastic_strain_rate(problem, e, deviator[i]));
  }
}

}  // namespace dccast::mechanics
