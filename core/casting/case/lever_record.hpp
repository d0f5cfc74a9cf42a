#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/results/levers_group.hpp"

namespace dccast::casting {

using results::Lever;
using results::lever_count;

/// All levers that a plant measures at one time.
struct LeverReading {
  double time = 0.0;  ///< [s] of the case
  /// (lever) [m/s], [°C], three times [m2/s], [°C], [m]; empty where it was not measured
  std::array<std::optional<double>, lever_count> value;

  std::optional<double>& of(Lever lever) { return value[static_cast<std::size_t>(lever)]; }
  const std::optional<double>& of(Lever lever) const {
    return value[static_cast<std::size_t>(lever)];
  }
};

/// A stretch of time over which a lever is known throughout or not at all.
struct LeverStretch {
  double from = 0.0;  ///< [s]
  double to = 0.0;    ///< [s]
  /// [unit of the lever times s]; empty where the lever is not known
  std::optional<double> integral;
};

/// The levers of a casting as they were measured, up to the last reading. Between two readings a
/// lever is interpolated linearly. A reading without it keeps its last value for `longest_gap`;
/// after that, and between readings farther apart, it is not known.
///
/// A value depends on the readings up to the next one only. A run that never goes beyond the last
/// reading is therefore the same, whether it follows the casting or repeats it.
class LeverRecord {
public:
  static constexpr double longest_gap = 10.0;  ///< [s]

  /// @param reading  of a later time than the last one
  /// @throws std::invalid_argument  it is not later
  void append(const LeverReading& reading);

  bool empty() const { return rows_.empty(); }
  /// Time of the last reading [s]. @pre not empty()
  double last() const { return rows_.back().time; }

  /// The lever at a time [s], in its unit; empty where it is not known.
  std::optional<double> at(Lever lever, double time) const;
  /// Divides a period into stretches, in their order. @param from, to  [s]
  std::vector<LeverStretch> stretches(Lever lever, double from, double to) const;

private:
  std::vector<LeverReading> rows_;              ///< by time; values as they were measured or kept
  std::array<double, lever_count> measured_{};  ///< (lever) [s] time of its last own value
};

}  // namespace dccast::casting
