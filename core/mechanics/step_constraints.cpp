#include "core/mechanics/step_constraints.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::mechanics {

int ActiveSet::update(std::span<const double> gap, std::span<const double> reaction,
                      const Tolerance& tolerance, bool one_by_one) {
  std::size_t worst = active_.size(), strongest = active_.size();
  double worst_excess = 0.0;
  std::vector<std::size_t> violators;

  for (std::size_t i = 0; i < active_.size(); ++i) {
    const double excess = active(i) ? -reaction[i] / tolerance.force : -gap[i] / tolerance.gap;
    const bool carries = i < carrying_ && active(i);
    if (carries && (strongest == active_.size() || reaction[i] > reaction[strongest])) {
      strongest = i;
    }
    if (excess <= 1.0) continue;
    violators.push_back(i);
    if (excess > worst_excess) worst_excess = excess, worst = i;
  }

  if (violators.empty()) return 0;
  if (one_by_one) violators.assign(1, worst);
  for (std::size_t i : violators) active_[i] = active(i) ? 0 : 1;

  const auto end = active_.begin() + static_cast<long>(carrying_);
  const bool all_open = std::none_of(active_.begin(), end, [](char a) { return a != 0; });
  if (all_open && strongest < carrying_) {
    active_[strongest] = 1;
    return static_cast<int>(violators.size()) - 1;
  }
  return static_cast<int>(violators.size());
}

double complementarity_error(std::span<const double> gap, std::span<const double> reaction,
                             double length_scale, double force_scale) {
  double error = 0.0;
  for (std::size_t i = 0; i < gap.size(); ++i) {
    const double g = gap[i] / length_scale, r = reaction[i] / force_scale;
    error = std::max({error, -g, -r, std::min(std::abs(g), std::abs(r))});
  }
  return error;
}

}  // namespace dccast::mechanics
