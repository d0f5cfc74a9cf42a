#include "core/findings/of_case.hpp"

namespace dccast::casting {

namespace {

struct Table {
  std::string key;
  const Curve* curve;
  double shift = 0.0;  ///< [s]
};

/// Every table that may depend on time or cast length, except the time step.
std::vector<Table> tables_of(const Case& c) {
  const thermal::BottomBlock& block = c.cooling.bottom_block;
  std::vector<Table> tables{
      {"schedule.casting_speed", &c.schedule.casting_speed, c.schedule.casting_speed_shift},
      {"schedule.casting_speed_factor", &c.schedule.casting_speed_factor},
      {"schedule.casting_temperature", &c.schedule.casting_temperature},
      {"schedule.water_flow", &c.schedule.water_flow, c.schedule.water_flow_shift},
      {"schedule.narrow_water_flow", &c.schedule.narrow_water_flow, c.schedule.water_flow_shift},
      {"schedule.water_flow_factor", &c.schedule.water_flow_factor},
      {"cooling.water.temperature", &c.cooling.water.temperature},
      {"cooling.water.coefficient", &c.cooling.water.coefficient},
      {"cooling.bottom_block.contact_coefficient", &block.contact_coefficient},
      {"cooling.bottom_block.temperature", &block.temperature},
  };
  for (std::size_t i = 0; i < c.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = c.cooling.zones[i];
    const std::string key = "cooling.zone[" + std::to_string(i) + "].";
    tables.push_back({key + "liquid_coefficient", &zone.liquid_coefficient});
    tables.push_back({key + "solid_coefficient", &zone.solid_coefficient});
    tables.push_back({key + "temperature", &zone.temperature});
  }
  return tables;
}

}  // namespace

std::optional<Finding> table_never_reached(const Case& c, const Course& course) {
  std::vector<std::string> keys;
  for (const Table& table : tables_of(c))
    if (never_reached(*table.curve, course, table.shift)) keys.push_back(table.key);
  if (keys.empty()) return std::nullopt;
  Finding finding;
  finding.code = "table_never_reached";
  finding.severity = Severity::warning;
  finding.message = "The casting ends before any change in " + listed(keys) +
                    ", or begins after the last one: one value holds throughout, as if the table "
                    "were a single number.";
  finding.key = keys.front();
  return finding;
}

}  // namespace dccast::casting
