#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/extrusion.hpp"

namespace dccast::linalg {

/// Storage layout of a symmetric matrix on an extruded mesh, by pairs of lines: the coupling of two
/// lines that share a cell is one array along the rows for each pair of unknowns and each of the
/// three neighbouring rows.
///
/// Arrays along the rows have `stride` numbers; those beyond the last row are zero, so that a loop
/// may read one number before its array and any number within the stride.
template <int PerNode>
class LineLayout {
public:
  static constexpr int entries = 3 * PerNode * PerNode;  ///< (unknown, unknown, 3 rows)

  /// Address of a block.
  struct Place {
    std::size_t pair = 0;  ///< index of the coupling; for a line with itself that of the line
    int row = 0;    ///< row on the line with the higher number; on a single line the upper row
    int below = 1;  ///< 0, 1, 2: the other row is one lower, the same, one higher
    bool transposed = false;  ///< the transpose of the block is stored
    bool one_line = false;
  };

  /// An empty layout.
  LineLayout() = default;
  /// Finds the pairs of lines that share a cell. The stride is the number of rows, rounded up to
  /// sixteen numbers.
  explicit LineLayout(const mesh::Extrusion& extruded)
      : lines_(extruded.lines),
        rows_(extruded.rows()),
        stride_((std::size_t(rows_) + 16) / 16 * 16) {
    std::vector<std::vector<int>> lower(std::size_t(lines_), std::vector<int>{});
    for (std::size_t c = 0; c < extruded.cell.size(); c += 4) {
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          const int high = extruded.cell[c + std::size_t(i)];
          const int low = extruded.cell[c + std::size_t(j)];
          if (low < high) lower[std::size_t(high)].push_back(low);
        }
      }
    }

    // Pairs by their higher line, each with its lower lines in ascending order.
    for (auto& neighbours : lower) {
      std::ranges::sort(neighbours);
      neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
      pair_line_.insert(pair_line_.end(), neighbours.begin(), neighbours.end());
      pair_start_.push_back(pair_line_.size());
    }
  }

  /// Numbers of vertical lines, of nodes on each, of numbers along a line, and of coupled pairs.
  int lines() const { return lines_; }
  int rows() const { return rows_; }
  std::size_t stride() const { return stride_; }
  std::size_t pairs() const { return pair_line_.size(); }
  /// Index of the first pair of a line, as the one with the higher number.
  std::size_t first_pair(int line) const { return pair_start_[std::size_t(line)]; }
  /// Line with the lower number of a pair.
  int low_line(std::size_t pair) const { return pair_line_[pair]; }

  /// Address of the block between two nodes (line, row) whose rows differ by at most one.
  Place place(int line, int row, int other, int other_row) const {
    if (line == other) {
      const bool upper = row >= other_row;
      return {std::size_t(line), upper ? row : other_row, row == other_row ? 1 : 0, !upper, true};
    }
    const bool swap = line < other;
    if (swap) {
      std::swap(line, other);
      std::swap(row, other_row);
    }

    // A line has few neighbours: search them one by one.
    std::size_t pair = first_pair(line);
    while (pair_line_[pair] != other) ++pair;
    return {pair, row, other_row - row + 1, swap, false};
  }
  /// Indices of the entries of a block in an array of this layout.
  struct Block {
    std::size_t first, along_row, along_column;
    std::size_t operator()(int a, int b) const {
      return first + std::size_t(a) * along_row + std::size_t(b) * along_column;
    }
  };
  /// Indices of a block; rows and columns are exchanged where its transpose is stored.
  Block block(const Place& place) const {
    const std::size_t start = place.pair * std::size_t(entries) + std::size_t(place.below);
    std::size_t row = std::size_t(3 * PerNode) * stride_, column = 3 * stride_;
    if (place.transposed) std::swap(row, column);
    return {start * stride_ + std::size_t(place.row), row, column};
  }

private:
  int lines_ = 0;
  int rows_ = 0;
  std::size_t stride_ = 0;
  std::vector<std::size_t> pair_start_{0};
  std::vector<int> pair_line_;
};

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
  void add(const typename LineLayout<PerNode>::Place& place, const double* block);
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
  /// Index in a vector of the first row of an unknown of a line.
  std::size_t first_row(int line, int unknown) const {
    return guard + std::size_t(line * PerNode + unknown) * layout_->stride();
  }
  /// Memory used [byte].
  std::size_t memory_bytes() const;

private:
  /// Numbers before and after a vector, so that a loop may read beyond its ends.
  static constexpr std::size_t guard = 16;
  /// Numbers of a block of one node.
  static constexpr int square = PerNode * PerNode;
  /// Factor at a node: inverse pivot, and the block below it times the inverse pivot below.
  struct Step {
    float inverse[square];
    float below[square];
  };

  /// Block factorisation of one line. @return false if it is not positive definite
  [[nodiscard]] bool factorize_line(int line);
  /// Solves the equations of one line, forward and backward.
  void solve_line(int line, const float* b, float* x) const;

  const LineLayout<PerNode>* layout_ = nullptr;
  std::vector<double> own_;      ///< of the lines with themselves, in the layout
  std::vector<float> coupling_;  ///< of the pairs, in the layout, between guards
  std::vector<Step> step_;       ///< (line, row)
};

extern template class LineRelaxation<3>;

}  // namespace dccast::linalg
