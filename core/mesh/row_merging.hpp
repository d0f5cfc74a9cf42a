#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace dccast::mesh {

/// Criteria for merging rows added by growth: two rows deep below the metal level, where fields
/// change slowly, become one (paper section 5.1: a mesh that is fine near the metal level and
/// coarse below).
struct RowMerging {
  /// [m] depth of a pair below the metal level at which it is merged; 0: never
  double below = 0.0;
  /// [m] largest height of a merged row; deeper down it may be a fifth of the depth of its top
  double largest_cell = 0.0;
};

/// Rows of nodes to remove, ascending and never two neighbours, so that the two rows of cells next
/// to each become one. Only pairs of equal height are merged, and never the two rows at the top,
/// which growth changes. Empty while too few rows can be removed to pay for a merging.
/// @param height  [m] of the rows of nodes, ascending
/// @param first   row of nodes below the first row of cells that may be merged
std::vector<int> rows_to_merge(std::span<const double> height, int first,
                               const RowMerging& merging);

/// Description of a merging of rows, for the transfer of fields.
struct MergedRows {
  std::vector<double> height;  ///< [m] of the rows of nodes before merging
  std::vector<int> taken_out;  ///< removed rows of nodes, from rows_to_merge()
  /// Nodes and elements of one row, before and after merging.
  std::size_t nodes_per_row = 0, elements_per_row = 0;

  bool empty() const { return taken_out.empty(); }
  /// (row of cells after merging) first and last of the rows of cells that were merged into it.
  std::vector<std::array<std::size_t, 2>> made_of() const;
};

/// Removes rows from an extensive field, such as heat or force by node: the content of a removed
/// row goes to the rows below and above, with the weights of linear interpolation.
/// @param per_row  numbers per row
/// @param field    [any unit]
void share_out_rows(const MergedRows& merged, std::size_t per_row, std::vector<double>& field);

/// Removes rows from a field by node or by row of nodes.
/// @param per_row  numbers per row
template <class T>
void take_out_rows(const MergedRows& merged, std::size_t per_row, std::vector<T>& field) {
  auto removed = merged.taken_out.begin();
  auto to = field.begin();
  for (std::size_t row = 0; row < merged.height.size(); ++row) {
    if (removed != merged.taken_out.end() && std::size_t(*removed) == row) {
      ++removed;
      continue;
    }

    const auto from = field.begin() + std::ptrdiff_t(row * per_row);
    to = std::copy_n(from, per_row, to);
  }
  field.erase(to, field.end());
}

}  // namespace dccast::mesh
