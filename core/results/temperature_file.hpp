#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/errors.hpp"

namespace dccast::results {

/// Prescribed temperatures at the nodes of a mesh: linear in time between the given times, constant
/// before the first and after the last.
class TemperatureHistory {
public:
  /// @param time         [s], strictly increasing, at least one
  /// @param temperature  (time, node) [°C]
  TemperatureHistory(std::vector<double> time, std::vector<double> temperature);

  std::size_t nodes() const { return temperature_.size() / time_.size(); }
  double begin() const { return time_.front(); }  ///< [s]
  double end() const { return time_.back(); }     ///< [s]
  /// Interpolates the temperatures at a time [s]. @param temperature  result (node) [°C]
  void at(double time, std::vector<double>& temperature) const;

private:
  std::vector<double> time_;         ///< [s]
  std::vector<double> temperature_;  ///< [°C]
};

/// Reads an HDF5 file with the datasets `time_s` (t) and `temperature_c` (t, node).
/// @param nodes   number of nodes of the mesh
/// @param faults  receives all faults, under the field "thermal.file"
/// @return        empty if there is a fault
std::optional<TemperatureHistory> read_temperature_file(const std::filesystem::path& path,
                                                        std::size_t nodes, Faults& faults);

}  // namespace dccast::results
