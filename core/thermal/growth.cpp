#include "core/thermal/growth.hpp"

#include <numeric>

#include "core/thermal/conduction.hpp"

namespace dccast::thermal {
namespace {

using mesh::Mesh2D;

double lumped_sum(const std::vector<double>& volume, const std::vector<double>& enthalpy) {
  return static_cast<double>(
      std::inner_product(volume.begin(), volume.end(), enthalpy.begin(), 0.0L));
}

/// Puts new rows into the stretched top row, from below, each between the last one and the top.
///
/// In a column a row of cells of height h holds w_b h at its lower and w_t h at its upper nodes;
/// the new node takes over what both lose, (w_b (h - c) H_b + w_t c H_t) of them, c its height
/// above the lower one. On rectangles w_b = w_t and that is linear interpolation; on triangles it
/// is the mean which conserves, column by column, and stays between its neighbours.
void divide_top_row(const Mesh2D& after, const std::vector<double>& stretched_volume,
                    const std::vector<double>& volume, std::size_t below_row,
                    std::size_t nodes_per_row, std::vector<double>& enthalpy) {
  const auto height = [&](std::size_t node) { return after.point(static_cast<int>(node))[1]; };
  const std::size_t first_new = below_row + nodes_per_row;
  enthalpy.resize(volume.size());
  const std::size_t top = volume.size() - nodes_per_row;
  for (std::size_t column = 0; column < nodes_per_row; ++column) {
    std::size_t lower = below_row + column, node = first_new + column;
    double left = height(top + column) - height(lower);
    const double top_enthalpy = enthalpy[node];
    const double upper_weight = stretched_volume[node] / left;
    const double lower_weight = (volume[node] - upper_weight * (height(node) - height(lower))) /
                                (height(node + nodes_per_row) - height(node));
    for (; node < top; lower = node, node += nodes_per_row) {
      const double cell = height(node) - height(lower);
      const double from_below = lower_weight * (left - cell), from_top = upper_weight * cell;
      enthalpy[node] =
          (from_below * enthalpy[lower] + from_top * top_enthalpy) / (from_below + from_top);
      left -= cell;
    }
    enthalpy[top + column] = top_enthalpy;
  }
}

}  // namespace

MetalEntry carry_enthalpy(const Mesh2D& before, const Mesh2D& after, int nodes_per_row,
                          mesh::SectionKind kind, double entering_enthalpy,
                          std::vector<double>& enthalpy) {
  const std::vector<double> old_volume = nodal_volumes(before, kind);
  const double stored_before = lumped_sum(old_volume, enthalpy);
  const std::vector<double> volume = nodal_volumes(after, kind);
  const double total_gain = std::accumulate(volume.begin(), volume.end(), 0.0) -
                            std::accumulate(old_volume.begin(), old_volume.end(), 0.0);
  const MetalEntry entry{stored_before, total_gain * entering_enthalpy};

  const std::size_t row = std::size_t(nodes_per_row);
  const std::size_t old_nodes = enthalpy.size();
  const bool divided = std::size_t(after.nodes()) > old_nodes;
  std::vector<double> stretched_volume = volume;
  if (divided) {
    Mesh2D stretched = before;
    for (std::size_t node = old_nodes - row; node < old_nodes; ++node) {
      stretched.node[2 * node + 1] = after.node.back();
    }
    stretched_volume = nodal_volumes(stretched, kind);
  }
  for (std::size_t node = old_nodes - 2 * row; node < old_nodes; ++node) {
    const double gained = stretched_volume[node] - old_volume[node];
    enthalpy[node] += gained / stretched_volume[node] * (entering_enthalpy - enthalpy[node]);
  }
  if (!divided) return entry;

  divide_top_row(after, stretched_volume, volume, old_nodes - 2 * row, row, enthalpy);
  return entry;
}

}  // namespace dccast::thermal
