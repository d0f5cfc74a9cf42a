#pragma once

#include <span>
#include <vector>

#include "core/linalg/line_layout.hpp"

namespace dccast::linalg {

/// Gauss-Seidel over the upright lines of an extruded mesh, each solved exactly, in single
/// precision: as a preconditioner it need not be exact, and half the bytes are half the time.
///
/// Flat cells couple their nodes upwards more than sideways by the square of their sides' ratio:
/// errors that vary along a line vanish at once.
template <int PerNode>
class LineRelaxation {
public:
  /// @param layout  must outlive the use of this object
  void start(const LineLayout<PerNode>& layout);

  /// Adds a block of the matrix: of a node, or between two with its transpose on the other side.
  /// @param block  (unknown of the row, unknown of the column)
  void add(const typename LineLayout<PerNode>::Place& at, const double* block);
  /// Factorises the lines. @return false when one is not positive definite
  bool factorize();

  /// x = lines in rising order from zero; residual = b - A x.
  void forward(const std::vector<float>& b, std::vector<float>& x,
               std::vector<float>& residual) const;
  /// Improves x by the lines in falling order. @param b  overwritten
  void backward(std::vector<float>& b, std::vector<float>& x) const;

  /// Numbers of a vector: guard, then (line, unknown, row along the stride), then guard.
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
  /// Of a node: inverse pivot, and the block below it times the inverse pivot below.
  struct Step {
    float inverse[square];
    float below[square];
  };

  bool factorize_line(int line);
  void solve_line(int line, const float* b, float* x) const;

  const LineLayout<PerNode>* layout_ = nullptr;
  std::vector<double> own_;      ///< of the lines with themselves, in the layout
  std::vector<float> coupling_;  ///< of the pairs, in the layout, between guards
  std::vector<Step> step_;       ///< (line, row)
};

extern template class LineRelaxation<1>;
extern template class LineRelaxation<3>;

}  // namespace dccast::linalg
