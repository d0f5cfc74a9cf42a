#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace dccast::linalg {

/// Updates of a kept factorisation by what the iterations have shown of the tangent since (BFGS).
///
/// An iteration moves by d and changes the residual by y. The inverse of the next one maps y to d
/// exactly and stays symmetric and positive definite, as the tangent of a convex energy is
/// (Matthies and Strang 1979). Only the pairs (d, y) are stored; a solution applies them before and
/// after that with the factor (the two loops of Nocedal 1980, eq. 4.1):
///
///     for k = newest .. oldest:  a_k = (d_k . b) / (y_k . d_k),  b -= a_k y_k
///     x = K^-1 b
///     for k = oldest .. newest:  x += d_k (a_k - (y_k . x) / (y_k . d_k))
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class SecantUpdates {
public:
  /// With more pairs a new factorisation is cheaper.
  static constexpr std::size_t most = 16;

  /// Allocates for a number of unknowns. Without pairs.
  void resize(std::size_t unknowns);

  void clear() { pairs_ = 0; }
  std::size_t pairs() const { return pairs_; }
  bool full() const { return pairs_ == most; }

  /// Adds a pair; skips one along which the residual does not grow. @pre not full()
  /// @param step    (unknown) d @param change  (unknown) y
  void add(std::span<const double> step, std::span<const double> change);

  /// Prepares a right-hand side for the solution with the factor.
  void before_solution(std::span<double> b);
  /// Completes that solution.
  void after_solution(std::span<double> x) const;

private:
  std::span<const double> step(std::size_t pair) const;
  std::span<const double> change(std::size_t pair) const;

  std::size_t unknowns_ = 0, pairs_ = 0;
  std::vector<double> steps_, changes_;  ///< (pair, unknown)
  std::array<double, most> work_{};      ///< (pair) y . d, twice the energy of the step
  std::array<double, most> share_{};     ///< (pair) a of the present solution
};

}  // namespace dccast::linalg
