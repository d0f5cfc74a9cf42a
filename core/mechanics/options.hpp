#pragma once

#include <optional>

namespace dccast::mechanics {

/// Algorithm of a mechanical step. newton is ours; the others are those of the paper, sections 4.2
/// to 4.4.
enum class Algorithm { newton, vnbm, sbm, nbm };
/// Model of the liquid metal: no part of the body, on which it presses; the paper's weak solid
/// (section 2.2); or a liquid that is treated as solid metal.
enum class Liquid { pressure, weak, solid };
/// How the mould holds a side that is not cold yet: exactly along its normal, or by springs (paper,
/// remark 3).
enum class Confinement { exact, penalty };
/// The strain measure.
enum class Kinematics {
  small_strain,  ///< symmetric gradient of the displacement, as in the paper
  corotational,  ///< the same after removing the rotation of each solid element,
                 ///< docs/developers/decisions.md
};

/// Parameters of the paper's algorithms; case.proto gives the section numbers.
struct AlgorithmParameters {
  double gamma_p = 0.0;            ///< [1/(Pa s)]
  std::optional<double> lambda_p;  ///< [Pa s]; absent: 1 / (2 gamma_p)
  double gamma_c = 0.0;            ///< [Pa/m]
  std::optional<double> lambda_c;  ///< [m/Pa]; absent: 1 / (2 gamma_c)
  double relaxation = 0.0;         ///< [1]
  // Variants for the paper's tables, no keys of a case.
  bool plain = false;           ///< nbm without Armijo rule and step control
  bool increment_test = false;  ///< stop on increments instead of the residual
};

/// Table `mechanics` of a case, without the keys that only the time loop needs.
struct Options {
  Algorithm algorithm = Algorithm::newton;
  Kinematics kinematics = Kinematics::small_strain;
  double gravity = 0.0;  ///< [m/s2]
  Liquid liquid = Liquid::pressure;
  double liquid_epsilon = 0.0;  ///< [1]
  double liquid_delta = 0.0;    ///< [1]
  double liquid_beta = 0.0;     ///< [1]
  /// The mould holds a side where it is not cold yet.
  bool confinement = false;
  Confinement confinement_by = Confinement::exact;
  double confinement_stiffness = 0.0;  ///< [Pa/m] of the springs
  double mould_length = 0.0;           ///< [m] below the level on which it hangs
  /// Unilateral contact with the bottom block; without it the bottom is held.
  bool contact = false;
  double tolerance = 0.0;  ///< [1] residual relative to the acting forces
  /// Absent: default of the algorithm, see iteration_limit()
  std::optional<int> maximum_iterations;
  AlgorithmParameters parameters;
  /// Number of unknowns of an extruded solid from which `newton` uses the two-grid solver instead
  /// of a factorisation. Measured; not a key of a case (docs/developers/factorisation.md).
  int two_grids_from_unknowns = 15000;
};

/// Number of iterations after which a step counts as not converged. The fixed-point methods need
/// hundreds, sbm with the paper's soft gamma_c up to 33,000 when a pair opens; a Newton step that
/// needs 60 will not converge.
inline int iteration_limit(const Options& options) {
  if (options.maximum_iterations) return *options.maximum_iterations;
  switch (options.algorithm) {
    case Algorithm::newton:
      return 60;
    case Algorithm::vnbm:
      return 2000;
    case Algorithm::nbm:
      return 2000;
    case Algorithm::sbm:
      return 100000;
  }
  return 0;
}

}  // namespace dccast::mechanics
