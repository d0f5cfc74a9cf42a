#include "core/results/levers_group.hpp"

#include <array>

#include "core/results/hdf5_file.hpp"

namespace dccast::results {

namespace {

struct Column {
  const char* dataset;
  const char* unit;
  const char* meaning;
  std::vector<double> MeasuredLevers::*member;
};
constexpr std::array columns{
    Column{"/levers/time_s", "s", "of the case", &MeasuredLevers::time},
    Column{"/levers/casting_speed_m_per_s", "m s-1", "of the bottom block",
           &MeasuredLevers::casting_speed},
    Column{"/levers/casting_temperature_c", "degC", "of the metal that is poured",
           &MeasuredLevers::casting_temperature},
    Column{"/levers/water_flow_m2_per_s", "m2 s-1", "per metre of perimeter",
           &MeasuredLevers::water_flow},
    Column{"/levers/narrow_water_flow_m2_per_s", "m2 s-1", "of the narrow face",
           &MeasuredLevers::narrow_water_flow},
    Column{"/levers/second_water_flow_m2_per_s", "m2 s-1", "of the second row of jets",
           &MeasuredLevers::second_water_flow},
    Column{"/levers/water_temperature_c", "degC", "of the water on the faces",
           &MeasuredLevers::water_temperature},
    Column{"/levers/metal_level_m", "m", "above that of the start", &MeasuredLevers::metal_level},
};

}  // namespace

void write_levers(hdf5::File& file, const MeasuredLevers& levers) {
  if (levers.time.empty()) return;

  file.create_group("/levers");
  for (const Column& column : columns) {
    const std::vector<double>& values = levers.*column.member;
    file.write(column.dataset, {values.size()}, values, column.unit, column.meaning);
  }
}

MeasuredLevers read_levers(const hdf5::File& file) {
  MeasuredLevers levers;
  if (!file.has("/levers")) return levers;

  levers.time = file.read_reals("/levers/time_s");
  for (const Column& column : columns)
    levers.*column.member = file.read_reals(column.dataset, levers.time.size());
  return levers;
}

}  // namespace dccast::results
