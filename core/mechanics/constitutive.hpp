#pragma once

#include "core/material/norton_hoff.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// The constitutive law of a step problem: backward-Euler return map and its consistent tangent
/// (Simo and Taylor 1985; for Norton's law one scalar equation in |s|).
template <int Dim>
class ReturnMapLaw {
public:
  explicit ReturnMapLaw(const StepProblem<Dim>& problem) : problem_(&problem) {}

  /// Computes the response at all points of a block from their trial strain deviators.
  void operator()(ElementBlock block, TensorBlock<Dim> trial, ResponseBlock<Dim> response) const {
    const auto shear = of_block(block, problem_->shear), kappa = of_block(block, problem_->kappa);
    with_lanes([&]<int Count>() {
      for (std::size_t q = 0; q < trial.points(); ++q) {
        for (std::size_t i = 0; i < block.elements(); i += Count) {
          const std::size_t place = place_in_block(i, q);
          response.template store<Count>(
              place, respond<Count>(trial.template load<Count>(place), load<Count>(&shear[i]),
                                    load<Count>(&kappa[i])));
        }
      }
    });
  }

private:
  template <int Count>
  PointResponse<Dim, Lanes<Count>> respond(const SymmetricTensor<Dim, Lanes<Count>>& trial,
                                           const Lanes<Count>& shear,
                                           const Lanes<Count>& kappa) const {
    using Numbers = Lanes<Count>;
    auto s = trial;
    for (Numbers& component : s.value) component *= 2.0 * shear;
    const Numbers norm = root<Count>(s.squared_norm());
    const Numbers creep = 2.0 * problem_->dt * shear * kappa;
    const auto map = material::return_maps<Count>(norm, creep, problem_->exponent);
    const Numbers one = Numbers{} + 1.0, ratio = norm > 0.0 ? map.norm / norm : one;
    for (Numbers& component : s.value) component *= ratio;
    const Numbers square = map.norm * map.norm;
    const Numbers softening = 2.0 * shear * (map.derivative - ratio) / square;
    return {s, shear * ratio, square > 0.0 ? softening : Numbers{}};
  }

  const StepProblem<Dim>* problem_;
};

template <int Dim>
ReturnMapLaw<Dim> return_map_law(const StepProblem<Dim>& problem) {
  return ReturnMapLaw<Dim>(problem);
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
