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

/// Enthalpy of the rows above `below_row`, linear in height between that row and the top.
void divide_top_row(const Mesh2D& after, std::size_t below_row, std::size_t nodes_per_row,
                    std::vector<double>& enthalpy) {
  const std::size_t old_top = below_row + nodes_per_row;
  const std::vector<double> top(enthalpy.begin() + static_cast<std::ptrdiff_t>(old_top),
                                enthalpy.end());
  enthalpy.resize(std::size_t(after.nodes()));
  const std::size_t new_top = enthalpy.size() - nodes_per_row;
  for (std::size_t node = old_top; node < enthalpy.size(); ++node) {
    const std::size_t column = node % nodes_per_row;
    const auto height = [&](std::size_t n) { return after.point(static_cast<int>(n))[1]; };
    const double low = height(below_row + column), high = height(new_top + column);
    const double share = (height(node) - low) / (high - low);
    enthalpy[node] = (1.0 - share) * enthalpy[below_row + column] + share * top[column];
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

  divide_top_row(after, old_nodes - 2 * row, row, enthalpy);
  const double defect = stored_before + entry.entered - lumped_sum(volume, enthalpy);
  double new_volume = 0.0;
  for (std::size_t node = old_nodes - row; node < volume.size(); ++node) new_volume += volume[node];
  for (std::size_t node = old_nodes - row; node < volume.size(); ++node) {
    enthalpy[node] += defect / new_volume;
  }
  return entry;
}

}  // namespace dccast::thermal
