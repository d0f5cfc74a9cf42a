#pragma once

#include <optional>

namespace dccast::mechanics {

enum class Algorithm { newton, vnbm, sbm, nbm };
enum class Liquid { prestressed, weak, solid };
/// How the mould holds a side that is not yet solid: along its normal exactly, or by springs
/// (paper, remark 3).
enum class Confinement { exact, penalty };
/// What strain a displacement gives.
enum class Kinematics {
  small_strain,  ///< its symmetric gradient, as in the paper
  corotational,  ///< the same beside the rotation of each solid element, docs/kinematics.md
};

/// Parameters of the paper's algorithms; section numbers stand in case.proto.
struct AlgorithmParameters {
  double gamma_p = 1.25e-12;       ///< [1/(Pa s)]
  std::optional<double> lambda_p;  ///< [Pa s]; absent: 1 / (2 gamma_p)
  double gamma_c = 5e8;            ///< [Pa/m]
  std::optional<double> lambda_c;  ///< [m/Pa]; absent: 1 / (2 gamma_c)
  double relaxation = 0.9;         ///< [1]
  bool plain = false;
  bool increment_test = false;
};

/// Table `mechanics` of a case, without what only the time loop needs.
struct Options {
  Algorithm algorithm = Algorithm::newton;
  Kinematics kinematics = Kinematics::small_strain;
  double gravity = 9.81;  ///< [m/s2]
  Liquid liquid = Liquid::prestressed;
  double liquid_modulus = 1e3;   ///< [Pa]
  double liquid_epsilon = 1e-3;  ///< [1]
  double liquid_delta = 2.0;     ///< [1]
  double liquid_beta = 1.0;      ///< [1]
  bool confinement = true;
  Confinement confinement_by = Confinement::exact;
  double confinement_stiffness = 1e12;  ///< [Pa/m] of the springs
  /// A side that the mould has let go of may lean on its wall and not pass it.
  bool mould_wall = false;
  double mould_length = 0.0;  ///< [m] of the mould below the metal level, for `mould_wall`
  bool contact = true;
  double tolerance = 1e-8;                ///< [1] residual relative to the forces that act
  std::optional<int> maximum_iterations;  ///< absent: by algorithm, see iteration_limit()
  AlgorithmParameters parameters;
  /// Unknowns of an extruded solid from which newton solves by two grids instead of a factor. No key of
  /// a case: the measured rule, docs/large-solids.md.
  int two_grids_from_unknowns = 15000;
};

/// Iterations after which a step counts as not converged. The fixed-point methods need their
/// hundreds, sbm with the paper's soft gamma_c 33,000 where a pair opens; a Newton step that needs
/// 60 is lost.
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
