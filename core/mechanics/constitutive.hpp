#pragma once

#include "core/mechanics/equilibrium.hpp"

namespace dccast::mechanics {

/// The law of a step problem itself: backward-Euler return map and its consistent tangent
/// (Simo and Taylor 1985; for Norton's law one scalar equation in |s|).
template <int Dim>
auto return_map_law(const StepProblem<Dim>& problem) {
  return [&problem](std::size_t e, std::size_t, const typename StepProblem<Dim>::Tensor& trial) {
    PointResponse<Dim> r;
    const double mu = problem.shear[e];
    r.deviator = trial;
    for (double& s : r.deviator.value) s *= 2.0 * mu;
    r.norm = r.deviator.norm();
    r.shear = mu;
    r.normal = 0.0;
    if (problem.kappa[e] <= 0.0 || r.norm <= 0.0) return r;
    const auto map = material::return_map(r.norm, 2.0 * mu * problem.dt * problem.kappa[e],
                                          problem.exponent);
    const double ratio = map.norm / r.norm;
    for (double& s : r.deviator.value) s *= ratio;
    r.norm = map.norm;
    r.shear = mu * ratio;
    r.normal = 2.0 * mu * (map.derivative - ratio);
    return r;
  };
}

/// Viscoplastic strain rate H(s) = kappa |s|^(q-2) s of an element, eq. (21) [1/s].
template <int Dim>
typename StepProblem<Dim>::Tensor viscoplastic_strain_rate(
    const StepProblem<Dim>& problem, std::size_t e,
    const typename StepProblem<Dim>::Tensor& deviator) {
  auto rate = deviator;
  const double factor =
      problem.kappa[e] > 0.0
          ? problem.kappa[e] * material::creep_power(deviator.norm(), problem.exponent)
          : 0.0;
  for (double& r : rate.value) r *= factor;
  return rate;
}

}  // namespace dccast::mechanics
