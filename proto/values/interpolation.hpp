#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace dccast::values {

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
      const double part = (instant - time_s[i - 1]) / (time_s[i] - time_s[i - 1]);
      result.push_back(value[i - 1] + part * (value[i] - value[i - 1]));
    }
  }
  return result;
}

}  // namespace dccast::values
