#pragma once

#include <algorithm>
#include <cmath>
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

/// Work vectors of conjugate gradients, by unknown.
template <class Number>
struct GradientVectors {
  std::vector<Number> solution, residual, preconditioned, direction, product;
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

  GradientVectors<double> vectors_;
};

/// The iterations of conjugate gradients, from x = 0 where the residual is the right-hand side.
/// @param v             `residual` holds the right-hand side
/// @param right_norm    its norm
/// @param precondition  computes `preconditioned` from `residual`
/// @param multiply      computes `product` from `direction`
/// @param dot           scalar product of two vectors
template <class Number, class Precondition, class Multiply, class Dot>
CgOutcome iterate_gradients(GradientVectors<Number>& v, double right_norm,
                            const Precondition& precondition, const Multiply& multiply,
                            const Dot& dot, const ConjugateGradients::Limits& limits) {
  std::fill(v.solution.begin(), v.solution.end(), Number(0));
  std::fill(v.direction.begin(), v.direction.end(), Number(0));
  CgOutcome outcome;
  outcome.residual = right_norm > 0.0 ? 1.0 : 0.0;
  double previous_energy = 1.0;

  // The negated comparison lets a residual that is not a number enter the loop; it ends as
  // indefinite there.
  while (!(outcome.residual <= limits.tolerance)) {
    outcome.end = CgOutcome::End::too_many;
    if (outcome.iterations == limits.iterations) break;

    // New direction, conjugate to the previous ones.
    precondition();
    const double energy = dot(v.residual, v.preconditioned);
    const Number share = outcome.iterations == 0 ? Number(0) : Number(energy / previous_energy);
    for (std::size_t i = 0; i < v.direction.size(); ++i)
      v.direction[i] = v.preconditioned[i] + share * v.direction[i];

    // Step length that minimises the energy along the direction.
    multiply();
    const double stiffness = dot(v.direction, v.product);
    outcome.end = CgOutcome::End::indefinite;
    if (!(energy > 0.0 && stiffness > 0.0 && std::isfinite(stiffness))) break;

    const Number length = Number(energy / stiffness);
    for (std::size_t i = 0; i < v.solution.size(); ++i) {
      v.solution[i] += length * v.direction[i];
      v.residual[i] -= length * v.product[i];
    }
    previous_energy = energy;

    ++outcome.iterations;
    outcome.residual = std::sqrt(dot(v.residual, v.residual)) / right_norm;
    outcome.end = CgOutcome::End::converged;
  }
  return outcome;
}

}  // namespace dccast::linalg
