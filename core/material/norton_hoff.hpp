#pragma once

#include "core/base/instructions.hpp"
#include "core/material/alloy_card.hpp"

namespace dccast::material {

/// Norton-Hoff creep law: viscoplastic strain rate kappa(T) |s|^(q-2) s, paper eq. (21).
struct NortonHoff {
  double factor = 0.0;                  ///< kappa without its Arrhenius factor [Pa^-(q-1)/s]
  double activation_temperature = 0.0;  ///< G/R [K]
  double zero_offset = 273.0;           ///< [K] added to °C; 273 as eq. (20) prints it
  double exponent = 2.0;                ///< q [1], at least 2

  /// kappa(T), eq. (20). @param temperature [°C] @return [Pa^-(q-1)/s]
  double kappa(double temperature) const;
};

/// Constants of a card; @see NortonHoffConstants, ReferenceCreep.
NortonHoff norton_hoff(const AlloyCard& card);

/// |s|^(q-2), the power in the law [Pa^(q-2)]. @param norm  |s| [Pa] @param exponent  q [1]
double creep_power(double norm, double exponent);

/// e0 of the hardening law of cold metal [1]: the strain at which the yield stress is read in a
/// tensile test, 0.2 %. @see ColdStrength
inline constexpr double hardening_strain = 2e-3;

/// Outcome of the scalar equation of the backward-Euler return map.
struct ReturnMap {
  double norm;        ///< |s| [Pa]
  double derivative;  ///< d|s| / d|s_trial|, in (0, 1] [1]
};

/// Solves x + c x^(q-1) = R for x = |s|, the deviator's norm after creep over one step.
/// @param trial_norm  R = |s_trial| [Pa], not negative
/// @param creep       c = 2 mu dt kappa [Pa^-(q-2)], not negative
/// @param exponent    q [1]
/// Newton from min(R, (R/c)^(1/(q-1))), which lies above the root of a convex increasing function:
/// the iterates fall monotonically to it.
ReturnMap return_map(double trial_norm, double creep, double exponent);

/// Solves x + c (x^2 + r^2)^((q-2)/2) x = R, the same with a second stress that adds to the rate.
/// @param trial_norm  R [Pa], not negative @param creep  c [Pa^-(q-2)], not negative
/// @param exponent    q [1] @param second  r [Pa], not negative
ReturnMap return_map(double trial_norm, double creep, double exponent, double second);

/// The same at several points at once; arguments and units as in return_map().
template <int Count>
struct ReturnMaps {
  Lanes<Count> norm;        ///< |s| [Pa]
  Lanes<Count> derivative;  ///< d|s| / d|s_trial|, in (0, 1] [1]
};
namespace detail {

/// x + c x^(q-1) = R, from the bound of return_map(). There c x^(q-2) needs no further power.
template <int Count>
ReturnMaps<Count> of_any_power(const Lanes<Count>& trial_norm, const Lanes<Count>& creep,
                               double exponent) {
  using Numbers = Lanes<Count>;
  const double m = exponent - 1.0;
  const Numbers one = Numbers{} + 1.0;

  const Numbers strength = creep * power<Count>(trial_norm, exponent - 2.0);  // c R^(q-2)
  const auto strong = (strength > 1.0) & (trial_norm > 0.0);
  Numbers x = trial_norm * power<Count>(strong ? strength : one, -1.0 / m);
  Numbers rate = strong ? trial_norm / x : strength;  // c x^(q-2)

  Numbers slope = one;
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    slope = 1.0 + m * rate;
    const Numbers step = (x + rate * x - trial_norm) / slope;
    x -= step;
    // The error is about the square of the step now: below round-off.
    if (!any<Count>((step < 0.0 ? -step : step) > 1e-9 * x)) break;
    rate = creep * power<Count>(x, exponent - 2.0);
  }
  return {x, 1.0 / slope};
}

/// x + c x^n = R for n = 3 or 5, from an upper bound: with strength = c R^(n-1) the root is at most
/// R strength^-e for each e below 1/n, here 5/16 or 3/16.
template <int Power, int Count>
ReturnMaps<Count> of_odd_power(const Lanes<Count>& trial_norm, const Lanes<Count>& creep) {
  static_assert(Power == 3 || Power == 5);
  using Numbers = Lanes<Count>;
  const auto creep_rate = [](const Numbers& factor, const Numbers& x) {  // factor x^(n-1)
    if constexpr (Power == 3) return Numbers(factor * (x * x));
    if constexpr (Power == 5) return Numbers(factor * (x * x) * (x * x));
  };

  const Numbers strength = creep_rate(creep, trial_norm);
  const Numbers fourth = root<Count>(root<Count>(strength)), eighth = root<Count>(fourth);
  const Numbers sixteenth = root<Count>(eighth);
  const Numbers bound = trial_norm / ((Power == 3 ? fourth : eighth) * sixteenth);

  Numbers x = strength > 1.0 ? bound : trial_norm;
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const Numbers power = creep_rate(creep, x);
    const Numbers step = (x + power * x - trial_norm) / (1.0 + double(Power) * power);
    x -= step;
    if (!any<Count>((step < 0.0 ? -step : step) > 1e-15 * trial_norm)) break;
  }
  return {x, 1.0 / (1.0 + creep_rate(double(Power) * creep, x))};
}

}  // namespace detail

/// return_map() of several points at once; for the exponents 4 and 6 without a power.
/// @param trial_norm  [Pa] @param creep  [Pa^-(q-2)] @param exponent  q [1]
template <int Count>
ReturnMaps<Count> return_maps(const Lanes<Count>& trial_norm, const Lanes<Count>& creep,
                              double exponent) {
  if (exponent == 4.0) return detail::of_odd_power<3, Count>(trial_norm, creep);
  if (exponent == 6.0) return detail::of_odd_power<5, Count>(trial_norm, creep);
  return detail::of_any_power<Count>(trial_norm, creep, exponent);
}

/// Volumetric over deviatoric creep factor of a porous body: a hollow sphere of the creeping metal
/// dilates at the rate K (3/2)^(n+1) [n (f^(-1/n) - 1)]^(-n) p^n under an outer tension p, where K
/// is the uniaxial factor of the metal, and kappa = K (3/2)^((n+1)/2).
/// @param porosity  f, share of the volume [1], 0 to below 1
/// @param exponent  n, stress exponent of the creep law [1]
/// @return          [1]; zero without porosity
double porous_ratio(double porosity, double exponent);

/// Mean stress that has the same share as a deviator in the equivalent stress of a porous body,
/// sigma^2 = A2 p^2 + 3/2 A3 |s|^2 with ratio = (A2 / (3/2 A3))^((n+1)/2).
/// @param norm      |s| [Pa]
/// @param ratio     volumetric over deviatoric creep factor, porous_ratio() [1], positive
/// @param exponent  n [1]
/// @return          [Pa]
double mean_stress_like(double norm, double ratio, double exponent);

/// The deviator's norm limited by yielding, after the return map of creep, at several points at
/// once. With hardening it solves x = y(e + k (R - x)), where y is the limit at an equivalent
/// strain and k (R - x) the strain of the step.
/// @param creep       return map of creep alone [Pa]
/// @param trial_norm  R = |s_trial| [Pa]
/// @param limit       y(0), the limit without hardening [Pa]
/// @param hardening   w of ColdStrength [1]; zero: ideal plasticity
/// @param strain      e at the start of the step [1]
/// @param strain_per_stress  k = sqrt(2/3) / (2 mu) [1/Pa]
/// Newton on a convex increasing function: after the first step the iterates fall to the root.
template <int Count>
ReturnMaps<Count> limit_by_yield(const ReturnMaps<Count>& creep, const Lanes<Count>& trial_norm,
                                 const Lanes<Count>& limit, const Lanes<Count>& hardening,
                                 const Lanes<Count>& strain,
                                 const Lanes<Count>& strain_per_stress) {
  using Numbers = Lanes<Count>;
  constexpr int most = 30;
  constexpr double close = 1e-14;  // [1] relative to the trial stress

  if (!any<Count>(creep.norm > limit)) return creep;

  Numbers x = limit, slope = Numbers{};
  for (int i = 0; i < most; ++i) {
    const Numbers beyond = trial_norm - x;
    const Numbers gained = strain_per_stress * (beyond > 0.0 ? beyond : Numbers{});
    const Numbers relative = 1.0 + (strain + gained) / hardening_strain;
    const Numbers fourth_root = root<Count>(root<Count>(relative));
    const Numbers yield = limit * (1.0 + hardening * (fourth_root - 1.0));
    // k dy/de
    slope =
        strain_per_stress * limit * hardening * fourth_root / (4.0 * hardening_strain * relative);
    const Numbers step = (x - yield) / (1.0 + slope);
    x -= step;
    if (!any<Count>((step < 0.0 ? -step : step) > close * trial_norm)) break;
  }

  const auto yields = x < creep.norm;
  return {yields ? x : creep.norm, yields ? slope / (1.0 + slope) : creep.derivative};
}

/// Root eta >= 1 of eta^(q-1) - eta^(q-2) = load, paper Lemma 3. Newton's method from an upper
/// bound of the root of a convex increasing function: it converges monotonically.
/// @param load      lambda_p kappa |zeta|^(q-2) / (1 - lambda_p gamma_p)^(q-1), not negative [1]
/// @param exponent  q [1]
/// @return          eta [1]
double yosida_root(double load, double exponent);

}  // namespace dccast::material
