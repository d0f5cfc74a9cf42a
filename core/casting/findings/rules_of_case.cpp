#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/casting/findings/rules.hpp"
#include "core/material/thermal_properties.hpp"

namespace dccast::casting {

namespace {

using Found = std::optional<Finding>;

/// A finding of the tables that no number describes.
Finding make_finding(std::string message, std::string key) {
  Finding finding;
  finding.message = std::move(message);
  finding.key = std::move(key);
  return finding;
}

/// A finding with a value and its limit, both [`unit`].
Finding make_measured_finding(std::string message, double value, double limit, std::string unit,
                              std::string key) {
  Finding finding = make_finding(std::move(message), std::move(key));
  finding.value = value;
  finding.limit = limit;
  finding.unit = std::move(unit);
  return finding;
}

/// Superheat of the coldest metal that is poured [K]; empty if none is poured.
std::optional<double> least_superheat(const Case& c, const Course& course) {
  const bool poured = c.cooling.top != thermal::Top::insulated && c.thermal.file.empty() &&
                      !c.schedule.casting_temperature.empty();
  if (!poured) return std::nullopt;
  return std::ranges::min(values_in(c.schedule.casting_temperature, course)) - c.alloy.liquidus;
}

/// The finding of metal that is poured with too little superheat. @param meaning  for the plant
Found poured_too_cold(const Case& c, double superheat, const char* meaning) {
  return make_measured_finding(
      fmt::format(
          "The metal is poured in at {:.6g} degC, {:.3g} K {} its liquidus of {:.6g} degC: {}.",
          superheat + c.alloy.liquidus, std::abs(superheat), superheat < 0.0 ? "below" : "above",
          c.alloy.liquidus, meaning),
      superheat, c.plausibility.minimum_superheat, "K", "schedule.casting_temperature");
}

Found poured_below_liquidus(const Case& c, const Course& course) {
  const auto superheat = least_superheat(c, course);
  if (!superheat || *superheat >= 0.0) return std::nullopt;

  const bool solid = *superheat + c.alloy.liquidus < c.alloy.solidus;
  return poured_too_cold(
      c, *superheat,
      solid ? "such metal is solid and cannot be poured"
            : "it freezes in the launder and on the float before it reaches the mould");
}

Found poured_with_little_superheat(const Case& c, const Course& course) {
  const auto superheat = least_superheat(c, course);
  if (!superheat || *superheat < 0.0 || *superheat >= c.plausibility.minimum_superheat)
    return std::nullopt;
  return poured_too_cold(c, *superheat, "it freezes early: cold shuts, and a float that blocks");
}

/// A mush carries tension only where its grains have grown together; below half it is a slurry
/// [A, docs/findings.md].
constexpr double least_solid_fraction = 0.5;

/// Coherency at the liquidus is the paper's choice and permitted; a temperature just below it does
/// not come from an alloy card.
Found coherency_in_liquid(const Case& c, const Course&) {
  const material::AlloyCard& alloy = c.alloy;
  if (!c.mechanics.enabled || c.mechanics.options.liquid == mechanics::Liquid::solid)
    return std::nullopt;
  if (alloy.coherency >= alloy.liquidus) return std::nullopt;

  // A plausible coherency lies in the mush, at a solid fraction that can carry load.
  const double solid = material::solid_fraction_at(alloy, alloy.coherency);
  const bool below_solidus = alloy.coherency < alloy.solidus;
  if (solid >= least_solid_fraction && !below_solidus) return std::nullopt;

  const std::string place =
      below_solidus ? fmt::format("{:.6g} K below the solidus", alloy.solidus - alloy.coherency)
                    : fmt::format("where {:.3g} of the metal is solid", solid);
  return make_measured_finding(
      fmt::format("Metal carries stress below a coherency of {:.6g} degC, {} (solidus {:.6g}, "
                  "liquidus {:.6g} degC): a value of another alloy, which changes the curl "
                  "silently? Write alloy.coherency_solid_fraction.",
                  alloy.coherency, place, alloy.solidus, alloy.liquidus),
      solid, least_solid_fraction, "1", "alloy.coherency");
}

Found water_never_meets(const Case& c, const Course& course) {
  if (!c.thermal.file.empty()) return std::nullopt;
  const auto found = [](const std::string& cause, const char* key) {
    return make_finding(fmt::format("{}: below the mould the shell loses its heat to the air "
                                    "alone, and the metal behind it melts it again.",
                                    cause),
                        key);
  };
  const auto flows = [&](const Curve& curve) {
    return std::ranges::any_of(values_in(curve, course), [](double value) { return value > 0.0; });
  };

  // The first cause that applies is reported: it makes the later ones meaningless.
  const thermal::Water& water = c.cooling.water;
  if (!water.enabled) return found("No water runs", "cooling.water.enabled");
  if (water.start >= course.end)
    return found(fmt::format("The water is turned on at {:.6g} s, after the end at {:.6g} s",
                             water.start, course.end),
                 "cooling.water.start");
  if (course.depth <= water.from)
    return found(fmt::format("The water line lies {:.4g} mm below the metal level, and the metal "
                             "is {:.4g} mm deep at the end",
                             in_mm * water.from, in_mm * course.depth),
                 "cooling.water.from");
  if (!flows(c.schedule.water_flow) || !flows(c.schedule.water_flow_factor))
    return found("The water flow is zero throughout", "schedule.water_flow");
  return std::nullopt;
}

constexpr double litres_per_min_per_m = 60e3;  ///< [(l/(min m))/(m2/s)]

/// Plants give a face 60 to 300 l/min/m (docs/water.md); a flow of all faces together is larger by
/// their perimeter [m2/s] [A].
constexpr double greatest_usual_flow = 400.0 / litres_per_min_per_m;

Found water_beyond_plants(const Case& c, const Course& course) {
  if (!c.thermal.file.empty() || !c.cooling.water.enabled) return std::nullopt;
  const double factor = std::ranges::max(values_in(c.schedule.water_flow_factor, course));
  double greatest = 0.0;
  std::string key;
  for (const auto& [name, flow] : {std::pair("schedule.water_flow", &c.schedule.water_flow),
                                   {"schedule.narrow_water_flow", &c.schedule.narrow_water_flow}}) {
    if (flow->empty()) continue;
    const double most = factor * std::ranges::max(values_in(*flow, course));
    if (most > greatest) greatest = most, key = name;
  }
  if (greatest <= greatest_usual_flow) return std::nullopt;

  return make_measured_finding(
      fmt::format(
          "The water reaches {:.4g} l/min per metre of perimeter, and plants give a face "
          "some 60 to 300: the law of its film was made for such flows. It may be the flow of "
          "all faces together.",
          litres_per_min_per_m * greatest),
      greatest, greatest_usual_flow, "m2/s", key);
}

/// Whether a zone lies under running water, which takes precedence over zones.
bool is_under_water(const thermal::CoolingSpec& cooling, const thermal::SideZone& zone,
                    const Course& course) {
  return cooling.water.enabled && cooling.water.start <= course.begin &&
         zone.from >= cooling.water.from;
}

Found zone_never_meets(const Case& c, const Course& course) {
  std::vector<std::string> names;
  std::string first;
  for (std::size_t i = 0; i < c.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = c.cooling.zones[i];
    if (zone.from < course.depth && !is_under_water(c.cooling, zone, course)) continue;
    names.push_back(fmt::format("'{}'", zone.name));
    if (first.empty()) first = fmt::format("cooling.zone[{}].from", i);
  }
  if (names.empty() || !c.thermal.file.empty()) return std::nullopt;

  // All zones make one finding, at the key of the first.
  return make_finding(
      fmt::format("The slab never reaches the cooling zone {} (metal {:.4g} mm deep at the end): "
                  "it has no effect, as if that part of the mould did not exist.",
                  listed(names), in_mm * course.depth),
      first);
}

/// A table of a case that depends on time or cast length.
struct Table {
  std::string key;
  const Curve* curve;
  double shift = 0.0;  ///< [s]
};

/// All such tables except the time step.
std::vector<Table> list_tables(const Case& c) {
  const thermal::BottomBlock& block = c.cooling.bottom_block;
  std::vector<Table> tables{
      {"schedule.casting_speed", &c.schedule.casting_speed, c.schedule.casting_speed_shift},
      {"schedule.casting_speed_factor", &c.schedule.casting_speed_factor},
      {"schedule.casting_temperature", &c.schedule.casting_temperature},
      {"schedule.water_flow", &c.schedule.water_flow, c.schedule.water_flow_shift},
      {"schedule.narrow_water_flow", &c.schedule.narrow_water_flow, c.schedule.water_flow_shift},
      {"schedule.water_flow_factor", &c.schedule.water_flow_factor},
      {"schedule.second_water_flow", &c.schedule.second_water_flow},
      {"schedule.metal_level", &c.schedule.metal_level},
      {"cooling.bottom_block.contact_coefficient", &block.contact_coefficient, block.first_metal},
      {"cooling.bottom_block.temperature", &block.temperature},
  };

  const auto add_water = [&](const std::string& key, const thermal::Water& water) {
    tables.push_back({key + "temperature", &water.temperature});
    tables.push_back({key + "critical_heat_flux_factor", &water.critical_heat_flux_factor});
    tables.push_back({key + "coefficient", &water.coefficient});
  };
  add_water("cooling.water.", c.cooling.water);
  if (c.cooling.narrow_water) add_water("cooling.narrow_water.", *c.cooling.narrow_water);

  for (std::size_t i = 0; i < c.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = c.cooling.zones[i];
    const std::string key = fmt::format("cooling.zone[{}].", i);
    tables.push_back({key + "liquid_coefficient", &zone.liquid_coefficient});
    tables.push_back({key + "solid_coefficient", &zone.solid_coefficient});
    tables.push_back({key + "temperature", &zone.temperature});
  }
  return tables;
}

Found table_never_reached(const Case& c, const Course& course) {
  std::vector<std::string> keys;
  for (const Table& table : list_tables(c))
    if (never_reached(*table.curve, course, table.shift)) keys.push_back(table.key);
  if (keys.empty()) return std::nullopt;
  return make_finding(
      fmt::format("The casting ends before any change in {}, or begins after the last one: one "
                  "value holds throughout, as if the table were a single number.",
                  listed(keys)),
      keys.front());
}

using enum Severity;

constexpr std::array rules{
    CaseRule{"no_superheat", danger, poured_below_liquidus},
    CaseRule{"no_superheat", warning, poured_with_little_superheat},
    CaseRule{"coherency_in_liquid", warning, coherency_in_liquid},
    CaseRule{"water_never_meets", warning, water_never_meets},
    CaseRule{"water_beyond_plants", warning, water_beyond_plants},
    CaseRule{"zone_never_meets", warning, zone_never_meets},
    CaseRule{"table_never_reached", warning, table_never_reached},
};

}  // namespace

std::span<const CaseRule> case_rules() {
  return rules;
}

}  // namespace dccast::casting
