#pragma once

#include "core/mechanics/options.hpp"

namespace dccast::testing {

/// Options of a body with its weight, on its block, held by the mould. Tests and verification
/// change single values of them; core itself has no defaults.
/// @param tolerance  [1] residual relative to the acting forces
inline mechanics::Options usual_options(double tolerance) {
  mechanics::Options options;
  options.gravity = 9.81;

  // The paper's weak liquid, eq. (38).
  options.liquid_epsilon = 1e-3;
  options.liquid_delta = 2.0;
  options.liquid_beta = 1.0;

  options.confinement = true;
  options.confinement_stiffness = 1e12;
  options.mould_length = 1.0;  // deeper than any of these slabs
  options.contact = true;

  options.tolerance = tolerance;
  // Multipliers of creep and contact in the algorithms of the paper.
  options.parameters.gamma_p = 1.25e-12;
  options.parameters.gamma_c = 5e8;
  options.parameters.relaxation = 0.9;
  return options;
}

}  // namespace dccast::testing
