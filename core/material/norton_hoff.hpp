#pragma once

#include "core/material/alloy_card.hpp"

namespace dccast::material {

/// Norton-Hoff creep law: viscoplastic strain rate kappa(T) |s|^(q-2) s, paper eq. (21).
struct NortonHoff {
  double factor = 0.0;                 ///< kappa without its Arrhenius factor [Pa^-(q-1)/s]
  double activation_temperature = 0.0; ///< G/R [K]
  double zero_offset = 273.0;          ///< [K] added to °C; 273 as eq. (20) prints it
  double exponent = 2.0;               ///< q [1], at least 2

  /// kappa(T), eq. (20). @param temperature [°C] @return [Pa^-(q-1)/s]
  double kappa(double temperature) const;
};

/// Constants of a card; @see NortonHoffConstants, ReferenceCreep.
NortonHoff norton_hoff(const AlloyCard& card);

/// |s|^(q-2), the one power of the law.
double creep_power(double norm, double exponent);

/// Outcome of the scalar equation of the backward-Euler return map.
struct ReturnMap {
  double norm;        ///< |s| [Pa]
  double derivative;  ///< d|s| / d|s_trial|, in (0, 1]
};

/// Solves x + c x^(q-1) = R for x = |s|, the deviator's norm after creep over one step.
/// @param trial_norm  R = |s_trial| [Pa], not negative
/// @param creep       c = 2 mu dt kappa [Pa^-(q-2)], not negative
/// @param exponent    q
/// Newton from min(R, (R/c)^(1/(q-1))), which lies above the root of a convex increasing function:
/// the iterates fall monotonically to it.
ReturnMap return_map(double trial_norm, double creep, double exponent);

}  // namespace dccast::material
