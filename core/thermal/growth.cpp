#include "core/thermal/growth.hpp"

#include <numeric>

namespace dccast::thermal {
namespace {

/// Inserts new rows into the stretched top row, from below, each between the previous one and the
/// top.
///
/// In a column a row of cells of height h holds w_b h at its lower and w_t h at its upper nodes;
/// the new node gets what both lose, w_b (h - c) H_b + w_t c H_t, with c its height above the lower
/// one. On rectangles and bricks w_b = w_t, and this is linear interpolation; on triangles and
/// tetrahedra it is a mean that conserves heat in each column and stays in the range of the
/// neighbours.
void divide_top_row(const GrownRows& rows, std::vector<double>& enthalpy) {
  const std::size_t per_row = rows.nodes_per_row, nodes = rows.volume_after.size();
  const std::size_t first_new = rows.volume_before.size() - per_row, top = nodes - per_row;

  enthalpy.resize(nodes);
  for (std::size_t column = 0; column < per_row; ++column) {
    std::size_t lower = first_new - per_row + column, node = first_new + column, row = 1;

    // Weights per height of the stretched row at its lower and upper nodes.
    double left = rows.height.back() - rows.height[0];
    const double top_enthalpy = enthalpy[node];
    const double upper_weight = rows.volume_stretched[node] / left;
    const double lower_weight =
        (rows.volume_after[node] - upper_weight * (rows.height[1] - rows.height[0])) /
        (rows.height[2] - rows.height[1]);

    while (node < top) {
      const double cell = rows.height[row] - rows.height[row - 1];
      const double from_below = lower_weight * (left - cell), from_top = upper_weight * cell;
      enthalpy[node] =
          (from_below * enthalpy[lower] + from_top * top_enthalpy) / (from_below + from_top);
      left -= cell;

      lower = node;
      node += per_row;
      ++row;
    }
    enthalpy[top + column] = top_enthalpy;
  }
}

}  // namespace

MetalEntry carry_enthalpy(const GrownRows& rows, double entering_enthalpy,
                          std::vector<double>& enthalpy) {
  // Metal that enters at the level fills the volume that nodes of the top row gain.
  const auto &before = rows.volume_before, &after = rows.volume_after;
  const double total_gain = std::accumulate(after.begin(), after.end(), 0.0) -
                            std::accumulate(before.begin(), before.end(), 0.0);
  const MetalEntry entry{heat_content(before, enthalpy), total_gain * entering_enthalpy};

  for (std::size_t node = before.size() - 2 * rows.nodes_per_row; node < before.size(); ++node) {
    const double stretched = rows.volume_stretched[node], gained = stretched - before[node];
    enthalpy[node] += gained / stretched * (entering_enthalpy - enthalpy[node]);
  }
  if (after.size() > before.size()) divide_top_row(rows, enthalpy);
  return entry;
}

void merge_enthalpy(const mesh::MergedRows& merged, std::span<const double> volume_before,
                    std::span<const double> volume_after, std::vector<double>& enthalpy) {
  std::vector<double> heat(enthalpy.size());  // [J]
  for (std::size_t n = 0; n < heat.size(); ++n) heat[n] = volume_before[n] * enthalpy[n];
  mesh::share_out_rows(merged, merged.nodes_per_row, heat);
  enthalpy.resize(heat.size());
  for (std::size_t n = 0; n < heat.size(); ++n) enthalpy[n] = heat[n] / volume_after[n];
}

double heat_content(std::span<const double> volume, std::span<const double> enthalpy) {
  return static_cast<double>(
      std::inner_product(volume.begin(), volume.end(), enthalpy.begin(), 0.0L));
}

}  // namespace dccast::thermal
