#include "core/thermal/row_merging.hpp"

#include <numeric>

namespace dccast::thermal {

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
