#include "core/results/temperature_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/results/hdf5_file.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::results {

namespace {

constexpr const char* case_key = "thermal.file";
/// Range of temperatures in a casting [°C]; values outside are in kelvin or from a wrong column.
constexpr double coldest = -273.15;
constexpr double hottest = 3000.0;

std::string format_shape(const hdf5::Shape& shape) {
  return fmt::format("({})", fmt::join(shape, ", "));
}

/// Adds at most one fault: a bad file has a million bad values.
void check_times(const std::string& name, const std::vector<double>& time, Faults& faults) {
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!std::isfinite(time[i]))
      return faults.add(case_key, name, fmt::format("time_s[{}] is not a number", i),
                        "finite times in s", "write the time of each row of temperature_c");
    if (i > 0 && time[i] <= time[i - 1])
      return faults.add(case_key, name,
                        fmt::format("time_s[{}] is not later than the one before", i),
                        "strictly increasing times in s", "sort the rows by time");
  }
}

/// Adds at most one fault.
void check_temperatures(const std::string& name, const std::vector<double>& temperature,
                        std::size_t nodes, Faults& faults) {
  for (std::size_t i = 0; i < temperature.size(); ++i) {
    if (temperature[i] >= coldest && temperature[i] <= hottest) continue;  // false for NaN
    return faults.add(
        case_key, name,
        fmt::format("temperature_c[{}, {}] = {:f}", i / nodes, i % nodes, temperature[i]),
        "-273.15 to 3000 degC", "write temperatures in degC");
  }
}

/// Whether both datasets exist and are consistent with each other and with the mesh.
bool check_shapes(const std::string& name, const hdf5::File& file, std::size_t nodes,
                  Faults& faults) {
  bool found = true;
  for (const char* dataset : {"/time_s", "/temperature_c"}) {
    if (file.has(dataset)) continue;
    faults.add(case_key, name, fmt::format("has no dataset {}", dataset),
               "time_s (t) in s and temperature_c (t, node) in degC", "add the dataset");
    found = false;
  }
  if (!found) return false;

  // One row of temperatures for each time, one column for each node.
  const auto time = file.shape_of("/time_s");
  const auto temperature = file.shape_of("/temperature_c");
  if (time.size() != 1 || time[0] == 0) {
    faults.add(case_key, name, fmt::format("time_s has the shape {}", format_shape(time)),
               "(t), t at least 1", "write the times as one row");
    return false;
  }
  if (temperature != hdf5::Shape{time[0], nodes}) {
    faults.add(case_key, name,
               fmt::format("temperature_c has the shape {}", format_shape(temperature)),
               fmt::format("{}: the times of time_s, the nodes of the mesh",
                           format_shape({time[0], nodes})),
               "write one row for each time, in the order of the nodes of the mesh");
    return false;
  }
  return true;
}

}  // namespace

TemperatureHistory::TemperatureHistory(std::vector<double> time, std::vector<double> temperature)
    : time_(std::move(time)), temperature_(std::move(temperature)) {}

void TemperatureHistory::at(double time, std::vector<double>& temperature) const {
  const std::size_t count = nodes();
  const auto next = std::upper_bound(time_.begin(), time_.end(), time);
  const auto right = static_cast<std::size_t>(next - time_.begin());
  temperature.resize(count);

  // Constant before the first time and after the last.
  if (right == 0 || right == time_.size()) {
    const std::size_t row = right == 0 ? 0 : right - 1;
    std::copy_n(temperature_.begin() + static_cast<std::ptrdiff_t>(row * count), count,
                temperature.begin());
    return;
  }

  const double share = (time - time_[right - 1]) / (time_[right] - time_[right - 1]);
  const double* before = temperature_.data() + (right - 1) * count;
  const double* after = temperature_.data() + right * count;
  for (std::size_t n = 0; n < count; ++n)
    temperature[n] = before[n] + share * (after[n] - before[n]);
}

std::optional<TemperatureHistory> read_temperature_file(const std::filesystem::path& path,
                                                        std::size_t nodes, Faults& faults) {
  const std::size_t faults_before = faults.list().size();
  const std::string name = path.filename().string();
  try {
    const hdf5::File file = hdf5::File::open(path);
    if (!check_shapes(name, file, nodes, faults)) return std::nullopt;

    // All faults of the content are reported at once.
    auto time = file.read_reals("/time_s");
    auto temperature = file.read_reals("/temperature_c");
    check_times(name, time, faults);
    check_temperatures(name, temperature, nodes, faults);
    if (faults.list().size() != faults_before) return std::nullopt;
    return TemperatureHistory(std::move(time), std::move(temperature));
  } catch (const storage::StorageError& error) {
    faults.add(case_key, name, error.what(), "a readable HDF5 file",
               "name an existing file, or leave thermal.file out");
    return std::nullopt;
  }
}

}  // namespace dccast::results
