#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace dccast::results::hdf5 {
class File;
}

namespace dccast::results {

/// What a plant moves while it casts.
enum class Lever {
  casting_speed,
  casting_temperature,
  water_flow,
  narrow_water_flow,
  second_water_flow,
  water_temperature,
  metal_level
};
inline constexpr std::size_t lever_count = 7;  ///< of Lever

/// What was measured of a casting that a run has followed, by time.
struct MeasuredLevers {
  std::vector<double> time;  ///< [s]
  /// (lever, time) in the unit of the lever, as SCHEMA.md has it; NaN where it was not measured
  std::array<std::vector<double>, lever_count> values;

  /// (time) of one lever, in its unit.
  std::vector<double>& of(Lever lever) { return values[static_cast<std::size_t>(lever)]; }
  /// The same.
  const std::vector<double>& of(Lever lever) const {
    return values[static_cast<std::size_t>(lever)];
  }
};

/// Writes the group /levers of SCHEMA.md, if anything was measured. @throws storage::StorageError
void write_levers(hdf5::File& file, const MeasuredLevers& measured);
/// Reads the group /levers; empty if the file has none.
/// @throws storage::StorageError  also if a column has the wrong length
MeasuredLevers read_levers(const hdf5::File& file);

}  // namespace dccast::results
