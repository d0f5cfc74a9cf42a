#include "core/mesh/row_merging.hpp"

#include <cmath>

namespace dccast::mesh {

namespace {

constexpr double same_height = 1e-6;  // relative
constexpr double round_off = 1e-9;    // relative
constexpr int top_rows = 2;           // of cells, which growth changes
/// A merging sets up the systems of heat and mechanics anew, which takes as long as a step: rows
/// wait until it removes at least one in so many.
constexpr std::size_t rows_per_removed = 32;
/// Height of a row, of its depth below the metal level [1]: what is deep is cold and changes
/// slowly.
constexpr double graded_share = 0.2;

}  // namespace

std::vector<int> rows_to_merge(std::span<const double> height, int first,
                               const RowMerging& merging) {
  std::vector<int> removed;
  if (merging.below <= 0.0 || height.empty()) return removed;

  const int last = static_cast<int>(height.size()) - 1 - top_rows;
  const double deepest = height.back() - merging.below;
  for (int row = first + 1; row + 1 <= last; ++row) {
    const std::size_t i = std::size_t(row);
    const double lower = height[i] - height[i - 1], upper = height[i + 1] - height[i];

    if (height[i + 1] > deepest) break;
    if (std::abs(upper - lower) > same_height * lower) continue;
    const double graded = graded_share * (height.back() - height[i + 1]);
    if (lower + upper > std::max(merging.largest_cell, graded) * (1.0 + round_off)) continue;

    removed.push_back(row);
    ++row;  // the next row of nodes is a boundary of the merged row
  }
  if (removed.size() * rows_per_removed < height.size()) removed.clear();
  return removed;
}

std::vector<std::array<std::size_t, 2>> MergedRows::made_of() const {
  std::vector<std::array<std::size_t, 2>> rows;
  auto removed = taken_out.begin();
  for (std::size_t cell = 0; cell + 1 < height.size(); ++cell) {
    const std::size_t first = cell;
    if (removed != taken_out.end() && std::size_t(*removed) == cell + 1) {
      ++cell;
      ++removed;
    }
    rows.push_back({first, cell});
  }
  return rows;
}

void share_out_rows(const MergedRows& merged, std::size_t per_row, std::vector<double>& field) {
  for (const int removed : merged.taken_out) {
    const std::size_t row = std::size_t(removed);
    const double below = merged.height[row] - merged.height[row - 1];
    const double above = merged.height[row + 1] - merged.height[row];

    for (std::size_t i = row * per_row; i < (row + 1) * per_row; ++i) {
      field[i - per_row] += field[i] * above / (below + above);
      field[i + per_row] += field[i] * below / (below + above);
    }
  }

  take_out_rows(merged, per_row, field);
}

}  // namespace dccast::mesh
