#pragma once

#include <vector>

namespace dccast::results::hdf5 {
class File;
}

namespace dccast::results {

/// What was measured of a casting that a run has followed, by time; NaN where it was not measured.
struct MeasuredLevers {
  std::vector<double> time;                 ///< [s]
  std::vector<double> casting_speed;        ///< [m/s]
  std::vector<double> casting_temperature;  ///< [°C]
  std::vector<double> water_flow;           ///< [m2/s]
  std::vector<double> narrow_water_flow;    ///< [m2/s]
  std::vector<double> second_water_flow;    ///< [m2/s]
  std::vector<double> water_temperature;    ///< [°C]
  std::vector<double> metal_level;          ///< [m] above that of the start
};

/// Writes the group /levers of SCHEMA.md, if anything was measured. @throws storage::StorageError
void write_levers(hdf5::File& file, const MeasuredLevers& levers);
/// Reads the group /levers; empty if the file has none.
/// @throws storage::StorageError  also if a column has the wrong length
MeasuredLevers read_levers(const hdf5::File& file);

}  // namespace dccast::results
