#pragma once

#include <span>
#include <vector>

#include "core/linalg/line_layout.hpp"

namespace dccast::linalg {

/// Line Gauss-Seidel over the vertical lines of an extruded mesh. Each line is solved exactly, in
/// single precision: a preconditioner need not be exact, and half the memory traffic is half the
/// time.
///
/// In flat cells the vertical coupling is stronger than the horizontal one by the square of the
/// aspect ratio: errors that vary along a line are removed at once.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
template <int PerNode>
class LineRelaxation {
public:
  /// @param layout  must outlive the use of this object
  void start(const LineLayout<PerNode>& layout);

  /// Adds a block of the matrix: of one node, or between two nodes, together with its transpose.
  /// @param block  (unknown of the row, unknown of the column)
  void add(const typename LineLayout<PerNode>::Place& at, const double* block);
  /// Factorises the lines. @return false if one is not positive definite
  [[nodiscard]] bool factorize();

  /// Forward sweep from x = 0; residual = b - A x.
  void forward(const std::vector<float>& b, std::vector<float>& x,
               std::vector<float>& residual) const;
  /// Backward sweep, improves x. @param b  overwritten
  void backward(std::vector<float>& b, std::vector<float>& x) const;

  /// Length of a vector: guard, then (line, unknown, row along the stride), then guard.
  std::size_t size() const {
    return 2 * guard + std::size_t(layout_->lines() * PerNode) * layout_->stride();
  }
  std::size_t place(int line, int unknown) const {
    return guard + std::size_t(line * PerNode + unknown) * layout_->stride();
  }
  std::size_t memory_bytes() const;

private:
  static constexpr std::size_t guard = 16;
  static constexpr int square = PerNode * PerNode;
  /// Factor at a node: inverse pivot, and the block below it times the inverse pivot below.
  struct Step {
    float inverse[square];
    float below[square];
  };

  [[nodiscard]] bool factorize_line(int line);
  void solve_line(int line, const float* b, float* x) const;

  const LineLayout<PerNode>* layout_ = nullptr;
  std::vector<double> own_;      ///< of the lines with themselves, in the layout
  std::vector<float> coupling_;  ///< of the pairs, in the layout, between guards
  std::vector<Step> step_;       ///< (line, row)
};

extern template class LineRelaxation<1>;
extern template class LineRelaxation<3>;

}  // namespace dccast::linalg
