#pragma once

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Preconditioner of a symmetric positive definite matrix with one unknown per node of an extruded
/// mesh: its vertical lines, each solved exactly, without their coupling to each other.
///
/// In flat cells the vertical coupling is stronger than the horizontal one by the square of the
/// aspect ratio, so that little is left to conjugate gradients. Nodes are numbered row by row:
/// a step of the elimination is one loop along a row, for all lines at once.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class LinePreconditioner {
public:
  /// @param lines  number of vertical lines: nodes per row
  LinePreconditioner(const SparsityPattern& pattern, int lines);

  /// @param pattern  that of the constructor
  /// @param values   its entries
  /// @return false if a line is not positive definite
  [[nodiscard]] bool factorize(const SparsityPattern& pattern, std::span<const double> values);

  /// z = M^-1 r. @param z  not the same storage as `r`
  void apply(std::span<const double> r, std::span<double> z) const;

private:
  std::size_t lines_;
  std::vector<int> above_;  ///< (node) entry of the pattern that couples it to the node above
  std::vector<double> inverse_pivot_;  ///< (node)
  std::vector<double> below_;  ///< (node) coupling to the node below times its inverse pivot
};

}  // namespace dccast::linalg
