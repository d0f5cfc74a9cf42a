#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/linalg/conjugate_gradients.hpp"
#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Conjugate gradients for a symmetric positive definite matrix with one unknown per node of an
/// extruded mesh. The preconditioner is its vertical lines, each solved exactly, without their
/// coupling to each other.
///
/// In flat cells the vertical coupling is stronger than the horizontal one by the square of the
/// aspect ratio, so that few iterations are left. Nodes are numbered row by row, and in a row layer
/// by layer, so that all entries lie on few diagonals. Every loop runs along a diagonal or a row,
/// in single precision: half the memory traffic, and as accurate as an iteration of Newton's method
/// needs.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class LineGradients {
public:
  /// Smallest residual that single precision reaches reliably [1], relative to the right-hand side.
  static constexpr double least_tolerance = 1e-5;

  /// Nothing if the entries lie on more diagonals than those of a plan of columns and layers.
  /// @param lines  number of vertical lines: nodes per row
  static std::optional<LineGradients> of(const SparsityPattern& pattern, int lines);

  /// @param pattern  that of the constructor
  /// @param values   its entries
  /// @param held     (unknown) not zero where the solution is zero
  /// @return false if a line is not positive definite
  [[nodiscard]] bool factorize(const SparsityPattern& pattern, std::span<const double> values,
                               std::span<const char> held);

  /// Solves with the matrix of the last factorize().
  /// @param b       right-hand side; must be zero where an unknown is held
  /// @param limits  its tolerance is at least least_tolerance
  CgOutcome solve(std::span<const double> b, std::span<double> x,
                  const ConjugateGradients::Limits& limits);

private:
  using Vector = std::vector<float>;

  /// @param offset  of the diagonals
  LineGradients(const SparsityPattern& pattern, int lines, std::vector<int> offset);
  /// The pivots of a line and its couplings, without those to held unknowns.
  [[nodiscard]] bool factorize_lines(const SparsityPattern& pattern, std::span<const double> values,
                                     std::span<const char> held);
  /// preconditioned = M^-1 residual.
  void solve_lines();
  /// product = A direction.
  void multiply();
  /// Components first to end of the product.
  void multiply(std::size_t first, std::size_t end);

  std::size_t unknowns_, lines_;
  std::vector<int> offset_;         ///< (diagonal) row minus column, positive, ascending
  std::vector<std::size_t> place_;  ///< (entry of the pattern) its index in `coupling_`
  std::vector<int> above_;          ///< (node) entry that couples it to the node above
  Vector diagonal_;                 ///< (node)
  Vector coupling_;                 ///< (diagonal, node) to the node with the higher number
  std::vector<double> pivot_;       ///< (node) of its line
  Vector inverse_pivot_;            ///< (node)
  Vector below_;                    ///< (node) coupling to the node below times its inverse pivot
  GradientVectors<float> vectors_;
};

}  // namespace dccast::linalg
