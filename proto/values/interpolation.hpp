#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace dccast::values {

/// Value of a table, linear between its points and constant outside.
/// @param at     ascending [unit of `x`]
/// @param value  as many, at least one [any unit]
inline double interpolate(std::span<const double> at, std::span<const double> value, double x) {
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(at, x) - at.begin());
  if (right == 0) return value.front();
  if (right == at.size()) return value.back();

  const double share = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return value[right - 1] + share * (value[right] - value[right - 1]);
}

/// Interpolates a curve linearly at other times; NaN outside its range.
/// @param instants_s  times of the result [s]
/// @param time_s      times of the curve [s]
/// @param value       [any unit]
/// @return            [unit of `value`]
inline std::vector<double> at_instants(const std::vector<double>& instants_s,
                                       const std::vector<double>& time_s,
                                       const std::vector<double>& value) {
  // Times that were summed over different steps agree up to rounding errors.
  constexpr double margin_s = 1e-6;

  std::vector<double> result;
  for (const double instant : instants_s) {
    const auto after = std::lower_bound(time_s.begin(), time_s.end(), instant - margin_s);
    const auto i = static_cast<std::size_t>(after - time_s.begin());

    if (after != time_s.end() && *after <= instant + margin_s) {
      result.push_back(value[i]);
    } else if (after == time_s.begin() || after == time_s.end()) {
      result.push_back(std::numeric_limits<double>::quiet_NaN());
    } else {
      result.push_back(interpolate(time_s, value, instant));
    }
  }
  return result;
}

}  // namespace dccast::values
