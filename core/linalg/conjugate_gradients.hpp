#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// How conjugate gradients ended.
struct [[nodiscard]] CgOutcome {
  enum class End {
    converged,
    too_many,    ///< not converged within the permitted iterations
    indefinite,  ///< a direction of non-positive curvature: matrix or preconditioner is not
                 ///< positive definite
  };
  End end = End::converged;
  int iterations = 0;
  double residual = 0.0;  ///< [1] norm on the free unknowns, relative to the right-hand side
};

/// Preconditioned conjugate gradients (Hestenes, Stiefel 1952) with some unknowns held at zero.
/// Held unknowns are masked in every vector; matrix and preconditioner are not modified: a
/// preconditioner built for other held unknowns remains symmetric and positive definite on the free
/// ones.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class ConjugateGradients {
public:
  /// Approximate solution of K z = r. @param z  not the same storage as `r`
  using Preconditioner = std::function<void(std::span<const double> r, std::span<double> z)>;
  /// When the iteration ends.
  struct Limits {
    double tolerance = 1e-10;  ///< [1] for CgOutcome::residual
    int iterations = 25;
  };

  /// @param values  entries of K, nothing held
  /// @param held    (unknown) not zero where x is zero; there `b` is not read
  /// @param x       solution; may be the same storage as `b`
  CgOutcome solve(const SparsityPattern& pattern, std::span<const double> values,
                  std::span<const char> held, const Preconditioner& precondition,
                  std::span<const double> b, std::span<double> x, const Limits& limits);

private:
  /// Starts from x = 0, where the residual is `b` on the free unknowns.
  void start(std::span<const double> b, std::span<const char> held);
  /// Sets the components of held unknowns to zero.
  void mask(std::span<const char> held, std::vector<double>& v) const;

  std::vector<double> solution_, residual_, preconditioned_, direction_, product_;
};

}  // namespace dccast::linalg
