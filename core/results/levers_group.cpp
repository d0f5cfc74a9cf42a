#include "core/results/levers_group.hpp"

#include <array>

#include "core/results/hdf5_file.hpp"

namespace dccast::results {

namespace {

constexpr const char* times = "/levers/time_s";

struct Column {
  Lever lever;
  const char* dataset;
  const char* unit;
  const char* meaning;
};
constexpr std::array<Column, lever_count> columns{{
    {Lever::casting_speed, "/levers/casting_speed_m_per_s", "m s-1", "of the bottom block"},
    {Lever::casting_temperature, "/levers/casting_temperature_c", "degC",
     "of the metal that is poured"},
    {Lever::water_flow, "/levers/water_flow_m2_per_s", "m2 s-1", "per metre of perimeter"},
    {Lever::narrow_water_flow, "/levers/narrow_water_flow_m2_per_s", "m2 s-1",
     "of the narrow face"},
    {Lever::second_water_flow, "/levers/second_water_flow_m2_per_s", "m2 s-1",
     "of the second row of jets"},
    {Lever::water_temperature, "/levers/water_temperature_c", "degC", "of the water on the faces"},
    {Lever::metal_level, "/levers/metal_level_m", "m", "above that of the start"},
}};

}  // namespace

void write_levers(hdf5::File& file, const MeasuredLevers& measured) {
  if (measured.time.empty()) return;

  file.create_group("/levers");
  const auto write = [&](const char* dataset, const std::vector<double>& values, const char* unit,
                         const char* meaning) {
    file.write(dataset, {values.size()}, values, unit, meaning);
  };
  write(times, measured.time, "s", "of the case");
  for (const Column& column : columns)
    write(column.dataset, measured.of(column.lever), column.unit, column.meaning);
}

MeasuredLevers read_levers(const hdf5::File& file) {
  MeasuredLevers measured;
  if (!file.has("/levers")) return measured;

  measured.time = file.read_reals(times);
  for (const Column& column : columns)
    measured.of(column.lever) = file.read_reals(column.dataset, measured.time.size());
  return measured;
}

}  // namespace dccast::results
