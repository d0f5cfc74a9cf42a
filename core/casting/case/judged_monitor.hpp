#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/casting/case/case.hpp"

namespace dccast::casting {

/// The monitor whose curl is judged: that of output.curl or, without that key, the one that has
/// curled most, upwards or downwards. Empty where it has no curl yet.
/// @param displacement  (monitor of the case, coordinate) [m]; the last coordinate is the curl
inline std::optional<std::size_t> judged_monitor(
    const Case& c, std::span<const std::vector<double>> displacement) {
  std::optional<std::size_t> judged;
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const bool counts = c.output.curl.empty() || c.monitors[i].name == c.output.curl;
    const double curl = displacement[i].back();
    if (!counts || !std::isfinite(curl)) continue;
    if (!judged || std::abs(curl) > std::abs(displacement[*judged].back())) judged = i;
  }
  return judged;
}

/// Its curl [m]; not a number where it has none yet.
inline double judged_curl(const Case& c, std::span<const std::vector<double>> displacement) {
  const auto judged = judged_monitor(c, displacement);
  return judged ? displacement[*judged].back() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace dccast::casting
