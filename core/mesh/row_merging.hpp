#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace dccast::mesh {

/// When rows of cells that have grown become coarser: two that lie deep, where nothing happens fast
/// any more, become one (paper section 5.1: a mesh that is fine near the metal level and coarse
/// below).
struct RowMerging {
  double below =
      0.0;  ///< [m] depth of a pair below the metal level at which it is merged; 0: never
  double largest_cell = 0.0;  ///< [m] height of a row made of two, at most
};

/// Rows of nodes to take out, rising and never two neighbours, so that the two rows of cells beside
/// each become one. Only pairs of one height are merged, and never the two rows at the top, which
/// growth moves.
/// @param height  [m] of the rows of nodes, rising
/// @param first   row of nodes below the first row of cells that may be merged
std::vector<int> rows_to_merge(std::span<const double> height, int first,
                               const RowMerging& merging);

/// A merging of rows, as those see it who carry fields over.
struct MergedRows {
  std::vector<double> height;  ///< [m] of the rows of nodes before
  std::vector<int> taken_out;  ///< rows of nodes, as rows_to_merge() gives them
  std::size_t nodes_per_row = 0, elements_per_row = 0;

  bool empty() const { return taken_out.empty(); }
  /// By row of cells after the merging, the lowest and the highest row before that it is made of.
  std::vector<std::array<std::size_t, 2>> made_of() const;
};

/// Takes rows out of a sum over rows, such as heat or force by node: what they hold goes to the
/// rows below and above, in the shares in which linear interpolation takes from them.
/// @param per_row  numbers of a row
void share_out_rows(const MergedRows& merged, std::size_t per_row, std::vector<double>& field);

/// Takes rows out of a field by node or by row of nodes.
/// @param per_row  numbers of a row
template <class T>
void take_out_rows(const MergedRows& merged, std::size_t per_row, std::vector<T>& field) {
  auto out = merged.taken_out.begin();
  auto to = field.begin();
  for (std::size_t row = 0; row < merged.height.size(); ++row) {
    if (out != merged.taken_out.end() && std::size_t(*out) == row) {
      ++out;
      continue;
    }
    const auto from = field.begin() + std::ptrdiff_t(row * per_row);
    for (std::size_t i = 0; i < per_row; ++i) *to++ = from[std::ptrdiff_t(i)];
  }
  field.erase(to, field.end());
}

}  // namespace dccast::mesh
