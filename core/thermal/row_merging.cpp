#include "core/thermal/row_merging.hpp"

#include <numeric>

namespace dccast::thermal {

void merge_enthalpy(const mesh::MergedRows& merged, std::span<const double> volume_before,
                    std::span<const double> volume_after, std::vector<double>& enthalpy) {
  const std::size_t per_row = merged.nodes_per_row;
  std::vector<double> heat(enthalpy.size());  // [J]
  for (std::size_t n = 0; n < heat.size(); ++n) heat[n] = volume_before[n] * enthalpy[n];
  for (const int out : merged.taken_out) {
    const std::size_t row = std::size_t(out);
    const double below = merged.height[row] - merged.height[row - 1];
    const double above = merged.height[row + 1] - merged.height[row];
    for (std::size_t n = row * per_row; n < (row + 1) * per_row; ++n) {
      heat[n - per_row] += heat[n] * above / (below + above);
      heat[n + per_row] += heat[n] * below / (below + above);
    }
  }
  mesh::take_out_rows(merged, per_row, heat);
  enthalpy.resize(heat.size());
  for (std::size_t n = 0; n < heat.size(); ++n) enthalpy[n] = heat[n] / volume_after[n];
}

double heat_content(std::span<const double> volume, std::span<const double> enthalpy) {
  return static_cast<double>(
      std::inner_product(volume.begin(), volume.end(), enthalpy.begin(), 0.0L));
}

}  // namespace dccast::thermal
