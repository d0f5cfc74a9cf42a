#pragma once

namespace dccast::material {

/// Root eta >= 1 of eta^(q-1) - eta^(q-2) = load, paper Lemma 3. Newton's method from an upper
/// bound of the root of a convex increasing function: it converges monotonically.
/// @param load      lambda_p kappa |zeta|^(q-2) / (1 - lambda_p gamma_p)^(q-1), not negative [1]
/// @param exponent  q [1]
/// @return          eta [1]
double yosida_root(double load, double exponent);

}  // namespace dccast::material
