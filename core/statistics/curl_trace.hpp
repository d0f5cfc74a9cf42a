#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace dccast::statistics {

/// The curl that is judged, over the last minute: whether it has settled (time.settled).
struct CurlTrace {
  static constexpr double length = 60.0;        ///< [s]
  static constexpr double round_off = 1e-9;     ///< [s] of summed steps
  static constexpr double least_curl = 1e-3;    ///< [m] before which nothing has settled
  static constexpr double least_cast = 100e-3;  ///< [m]

  std::vector<double> time;  ///< [s] increasing
  std::vector<double> curl;  ///< [m]

  /// Adds the curl at the end of a step, and forgets what is older than a minute. A curl that is
  /// not a number begins anew.
  void add(double at, double value) {
    if (!std::isfinite(value)) return clear();
    time.push_back(at);
    curl.push_back(value);
    const auto first = std::ranges::upper_bound(time, at - length + round_off);
    const long old = std::max(0L, static_cast<long>(first - time.begin()) - 1);
    time.erase(time.begin(), time.begin() + old);
    curl.erase(curl.begin(), curl.begin() + old);
  }

  void clear() {
    time.clear();
    curl.clear();
  }

  /// How far the curl has moved to and fro in the last minute, by second [m/s]; empty: it is not
  /// known for so long.
  std::optional<double> rate() const {
    if (time.empty() || time.back() - time.front() < length - round_off) return std::nullopt;
    const auto [least, greatest] = std::ranges::minmax(curl);
    return (greatest - least) / (time.back() - time.front());
  }

  /// Whether the curl has settled. @param limit  of its rate [m/s] @param cast_length  [m]
  bool has_settled(double limit, double cast_length) const {
    const std::optional<double> moves = rate();
    return moves && *moves < limit && std::abs(curl.back()) >= least_curl &&
           cast_length >= least_cast;
  }
};

}  // namespace dccast::statistics
