#include <algorithm>
#include <cmath>

#include "core/case/check/checks.hpp"

namespace dccast::casting {

namespace {

constexpr double largest_speed = 0.1, largest_flow = 0.1;  // [m/s], [m2/s], of the schema

bool against_length(const Curve& curve) {
  return curve.abscissa() == Abscissa::cast_length;
}

double largest(const Curve& curve) {
  return *std::max_element(curve.value().begin(), curve.value().end());
}

/// A factor must keep the quantity that it multiplies within its range.
void check_factor(CaseFindings& found, const std::string& key, const Curve& table,
                  const Curve& factor, double limit, const char* unit) {
  if (table.empty() || largest(factor) <= 1.0) return;
  const std::string factor_key =
      key == "schedule.casting_speed" ? key + "_factor" : "schedule.water_flow_factor";
  if (!found.sound({key, factor_key})) return;
  const double product = largest(table) * largest(factor);
  if (product <= limit) return;
  found.fault(factor_key, largest(factor), "leads to " + with_unit(product, unit) + " with " + key,
              "products of at most " + with_unit(limit, unit), "choose a smaller factor");
}

/// A table against cast length cannot be delayed in time.
void check_shift(CaseFindings& found, const std::string& key, const Curve& table, double shift) {
  if (shift == 0.0 || table.empty() || !found.sound({key, key + "_shift"})) return;
  if (!against_length(table)) return;
  found.fault(key + "_shift", with_unit(shift, "s"),
              "moves a table against time, and " + key + " stands against cast length",
              "0 s with a table against cast length", "move the points of the table instead");
}

void check_pulses(CaseFindings& found, const std::string& key, const thermal::Water& water) {
  if (water.pulse_period <= 0.0 || !water.enabled) return;
  if (!found.sound({key + ".pulse_period", key + ".pulse_share", key + ".pulse_end", key + ".start",
                    "time.minimum_step", "time.end"}))
    return;
  const double share = std::min(water.pulse_share, 1.0 - water.pulse_share);
  const double shortest = water.pulse_period * (share > 0.0 ? share : 1.0);
  if (shortest < found.casting.time.minimum_step) {
    found.fault(
        key + ".pulse_period", with_unit(water.pulse_period, "s"),
        "opens or closes the valve for less than the smallest time step",
        "parts of at least time.minimum_step = " + with_unit(found.casting.time.minimum_step, "s"),
        "lengthen the period");
  }
  const double last = std::min(water.pulse_end, found.casting.time.end);
  const double changes = 2.0 * (last - water.start) / water.pulse_period;
  if (changes > static_cast<double>(found.casting.limits.maximum_steps)) {
    found.fault(key + ".pulse_period", with_unit(water.pulse_period, "s"),
                "moves the valve more often than there are time steps",
                "at most limits.maximum_steps = " +
                    std::to_string(found.casting.limits.maximum_steps) + " times",
                "lengthen the period or end the pulses earlier");
  }
  if (water.pulse_end <= water.start) {
    found.warning(key + ".pulse_end", with_unit(water.pulse_end, "s"),
                  "does not lie after the water's start, so that nothing is pulsed",
                  "more than " + key + ".start = " + with_unit(water.start, "s"),
                  "give the time until which the water is pulsed");
  }
}

/// Cooling keys that require a slab with two faces; check_quarter_slab checks the rest.
void check_faces(CaseFindings& found) {
  if (found.casting.section.kind == mesh::SectionKind::quarter_slab) return;
  if (!found.sound({"section.kind"})) return;
  const auto only_of_a_slab = [&](const std::string& key, const char* value) {
    found.fault(key, value, "names a face, and the section has one side",
                "section.kind = \"quarter_slab\" with a face of its own", "leave it out");
  };
  for (std::size_t i = 0; i < found.casting.cooling.zones.size(); ++i) {
    const auto& face = found.casting.cooling.zones[i].face;
    if (face)
      only_of_a_slab("cooling.zone[" + std::to_string(i) + "].face",
                     *face == thermal::Face::wide ? "wide" : "narrow");
  }
  if (found.casting.cooling.narrow_water) only_of_a_slab("cooling.narrow_water", "given");
  if (!found.casting.schedule.narrow_water_flow.empty())
    only_of_a_slab("schedule.narrow_water_flow", "given");
}

}  // namespace

void check_levers(CaseFindings& found) {
  const Schedule& s = found.casting.schedule;
  check_factor(found, "schedule.casting_speed", s.casting_speed, s.casting_speed_factor,
               largest_speed, "m/s");
  check_factor(found, "schedule.water_flow", s.water_flow, s.water_flow_factor, largest_flow,
               "m2/s");
  check_factor(found, "schedule.narrow_water_flow", s.narrow_water_flow, s.water_flow_factor,
               largest_flow, "m2/s");
  check_shift(found, "schedule.casting_speed", s.casting_speed, s.casting_speed_shift);
  check_shift(found, "schedule.water_flow", s.water_flow, s.water_flow_shift);
  check_pulses(found, "cooling.water", found.casting.cooling.water);
  if (found.casting.cooling.narrow_water)
    check_pulses(found, "cooling.narrow_water", *found.casting.cooling.narrow_water);
  check_faces(found);
}

}  // namespace dccast::casting
