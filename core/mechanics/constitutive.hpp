#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/material/norton_hoff.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// Relation between |s_trial| - |s| and the equivalent viscoplastic strain of a step: sqrt(2/3)
/// |e|, |e| = (|s_trial| - |s|) / (2 mu).
inline const double equivalent_of_norm = std::sqrt(2.0 / 3.0);  // [1]

/// The constitutive law of a step problem: backward-Euler return map and its consistent tangent
/// (Simo and Taylor 1985; for Norton's law one scalar equation in |s|). Where the metal yields, |s|
/// is the smaller one of creep and yielding.
template <int Dim>
class ReturnMapLaw {
public:
  explicit ReturnMapLaw(const StepProblem<Dim>& problem) : problem_(&problem) {}

  /// Computes the response at all points of a block from their trial strain deviators.
  void operator()(ElementBlock block, TensorBlock<Dim> trial, ResponseBlock<Dim> response) const {
    const auto shear = of_block(block, problem_->shear), kappa = of_block(block, problem_->kappa);
    const Yielding yielding(*problem_, block, trial.points());

    with_lanes([&]<int Count>() {
      for (std::size_t q = 0; q < trial.points(); ++q) {
        for (std::size_t i = 0; i < block.elements(); i += Count) {
          const std::size_t place = place_in_block(i, q);
          response.template store<Count>(
              place, respond<Count>(trial.template load<Count>(place), load<Count>(&shear[i]),
                                    load<Count>(&kappa[i]), yielding, i, q));
        }
      }
    });
  }

private:
  /// What limits the stress of the elements of a block.
  struct Yielding {
    /// Without a yield limit the object stays empty, and operator bool is false.
    /// @param points_of_element  number of integration points of each element
    Yielding(const StepProblem<Dim>& problem, ElementBlock block, std::size_t points_of_element) {
      if (problem.yield.empty()) return;
      limit = of_block(block, problem.yield);
      hardening = of_block(block, problem.hardening);
      strain = &problem.hardened[block.first * points_of_element];
      points = points_of_element;
      elements = block.elements();
    }
    explicit operator bool() const { return strain != nullptr; }

    /// Equivalent strains of the elements that share a register [1].
    template <int Count>
    Lanes<Count> strains(std::size_t element, std::size_t point) const {
      return lanes_of<Count>([&](std::size_t lane) {
        const std::size_t e = std::min(element + lane, elements - 1);
        return strain[e * points + point];
      });
    }

    std::array<double, elements_in_block> limit, hardening;  ///< (element) [Pa], [1]
    const double* strain = nullptr;                          ///< (element, point) [1]
    std::size_t points = 0, elements = 0;
  };

  /// Response of the elements that share a register, at one point. With s_trial = 2 mu e the radial
  /// return scales the trial stress, s = (|s| / |s_trial|) s_trial, and the tangent follows from
  /// d|s| / d|s_trial|.
  /// @param trial    trial strain deviator e [1]
  /// @param shear    mu [Pa]
  /// @param kappa    [Pa^-(q-1)/s], zero without creep
  /// @param element  first of the elements, within the block
  template <int Count>
  PointResponse<Dim, Lanes<Count>> respond(const SymmetricTensor<Dim, Lanes<Count>>& trial,
                                           const Lanes<Count>& shear, const Lanes<Count>& kappa,
                                           const Yielding& yielding, std::size_t element,
                                           std::size_t point) const {
    using Numbers = Lanes<Count>;
    auto s = trial;
    for (Numbers& component : s.value) component *= 2.0 * shear;
    const Numbers norm = root<Count>(s.squared_norm());
    const Numbers creep = 2.0 * problem_->dt * shear * kappa;
    // |s| from creep alone: |s| + 2 mu dt kappa |s|^(q-1) = |s_trial|.
    auto map = material::return_maps<Count>(norm, creep, problem_->exponent);
    // Cold metal yields where creep would leave a larger stress.
    if (yielding) {
      map = material::limit_by_yield<Count>(map, norm, load<Count>(&yielding.limit[element]),
                                            load<Count>(&yielding.hardening[element]),
                                            yielding.template strains<Count>(element, point),
                                            equivalent_of_norm / (2.0 * shear));
    }
    // d s / d e = 2 mu~ I + softening s (x) s, with mu~ = mu |s| / |s_trial|.
    const Numbers one = Numbers{} + 1.0, ratio = norm > 0.0 ? map.norm / norm : one;
    for (Numbers& component : s.value) component *= ratio;
    const Numbers square = map.norm * map.norm;
    const Numbers softening = 2.0 * shear * (map.derivative - ratio) / square;
    return {s, shear * ratio, square > 0.0 ? softening : Numbers{}};
  }

  const StepProblem<Dim>* problem_;
};

/// The law of a problem, which must outlive it.
template <int Dim>
ReturnMapLaw<Dim> return_map_law(const StepProblem<Dim>& problem) {
  return ReturnMapLaw<Dim>(problem);
}

/// Mean stress of an element and its derivative by the dilatation.
struct MeanStress {
  double stress;   ///< p [Pa]
  double tangent;  ///< dp / d tr [Pa]
};

/// The mean stress after the volumetric creep of the mush: with p the stress beyond the pressure of
/// the melt, the dilatation creeps at the rate kappa_v (p^2 + r^2)^((q-2)/2) p, r = linear_below.
/// @param trial  mean stress without that creep [Pa]
template <int Dim>
MeanStress relaxed_mean_stress(const StepProblem<Dim>& problem, std::size_t e, double trial) {
  if (problem.volumetric_kappa.empty() || problem.volumetric_kappa[e] <= 0.0)
    return {trial, problem.bulk[e]};

  const double effective = trial + problem.melt_pressure[e];
  const double creep = problem.bulk[e] * problem.dt * problem.volumetric_kappa[e];
  const auto map =
      material::return_map(std::abs(effective), creep, problem.exponent, problem.linear_below[e]);
  return {std::copysign(map.norm, effective) - problem.melt_pressure[e],
          problem.bulk[e] * map.derivative};
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

/// Viscoplastic increments of a converged step at one point [1].
template <int Dim>
struct ViscoplasticIncrement {
  SymmetricTensor<Dim> strain;  ///< deviatoric, and the dilatation of creeping mush
  double equivalent = 0.0;      ///< sqrt(2/3) of the deviator's norm
};

/// @param deviator  s at the end of the step [Pa]
/// @param u         displacement at the end of the step, by unknown [m]
template <int Dim>
ViscoplasticIncrement<Dim> viscoplastic_increment(const StepProblem<Dim>& problem, std::size_t e,
                                                  std::size_t point,
                                                  const SymmetricTensor<Dim>& deviator,
                                                  std::span<const double> u) {
  const std::size_t i = e * problem.forms->points() + point;
  ViscoplasticIncrement<Dim> increment;
  increment.strain.add(problem.dt, viscoplastic_strain_rate(problem, e, deviator));

  // Where the metal yields, creep explains only a part of what the stress lacks.
  constexpr double round_off = 1e-9;  // [1]
  const double norm = deviator.norm();
  if (!problem.yield.empty() && norm > 0.0 && norm >= (1.0 - round_off) * problem.yield[e]) {
    // The viscoplastic strain is the trial strain less the elastic one; what exceeds the creep
    // strain is plastic and has the direction of s.
    auto trial = problem.forms->strain(e, point, u);
    trial.add(-1.0, problem.inelastic[i]);
    const double whole = trial.deviator().norm() - norm / (2.0 * problem.shear[e]);
    const double plastic = std::max(0.0, whole - increment.strain.norm());
    increment.strain.add(plastic / norm, deviator);
  }
  increment.equivalent = equivalent_of_norm * increment.strain.norm();

  // The dilatation of creeping mush is what the mean stress has relaxed, over the bulk modulus.
  if (!problem.volumetric_kappa.empty() && problem.volumetric_kappa[e] > 0.0) {
    const double inelastic = problem.inelastic[i].trace() + 3.0 * problem.thermal[e];
    const double trial =
        problem.bulk[e] * (problem.forms->mean_dilatation(e, u) - inelastic) + problem.prestress[e];
    const double relaxed = trial - relaxed_mean_stress(problem, e, trial).stress;
    increment.strain.add_identity(relaxed / (3.0 * problem.bulk[e]));
  }
  return increment;
}

/// Adds the viscoplastic strain increment of a converged step to one or more strain arrays.
/// @param u         displacement at the end of the step, by unknown [m]
/// @param hardened  (element, point) equivalent strain that has hardened the metal [1]; not used
///                  without a yield limit
/// @param strain    (element, point) at the start of the step on entry, at its end on return [1]
template <int Dim, class... Strain>
void accumulate_viscoplastic_strain(const StepProblem<Dim>& problem,
                                    const std::vector<SymmetricTensor<Dim>>& deviator,
                                    std::span<const double> u, std::vector<double>& hardened,
                                    Strain&... strain) {
  const std::size_t points = problem.forms->points();
  for (std::size_t e = 0; e < problem.kappa.size(); ++e) {
    if (problem.kappa[e] <= 0.0) continue;
    for (std::size_t q = 0; q < points; ++q) {
      const std::size_t i = e * points + q;
      const auto increment = viscoplastic_increment(problem, e, q, deviator[i], u);
      (strain[i].add(1.0, increment.strain), ...);
      if (!problem.yield.empty() && problem.hardening[e] > 0.0) hardened[i] += increment.equivalent;
    }
  }
}

}  // namespace dccast::mechanics
