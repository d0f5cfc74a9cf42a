#include <algorithm>
#include <cmath>
#include <utility>

#include "core/case/casting_schedule.hpp"
#include "core/case/checks.hpp"

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

namespace {

void increasing(CaseFindings& found, const char* field, const Curve& curve, const char* unit) {
  if (!found.fault_of(field).empty()) return;  // already reported
  for (std::size_t i = 1; i < curve.at().size(); ++i) {
    if (curve.at()[i] > curve.at()[i - 1]) continue;
    found.fault(field, with_unit(curve.at()[i], unit), "does not lie above the point before it",
                "strictly increasing first values", "sort the table and remove repeated points");
    return;
  }
}

}  // namespace

void check_tables(CaseFindings& found) {
  increasing(found, "schedule.casting_speed", found.casting.schedule.casting_speed, "");
  increasing(found, "schedule.casting_temperature", found.casting.schedule.casting_temperature, "");
  increasing(found, "schedule.water_flow", found.casting.schedule.water_flow, "");
  increasing(found, "schedule.narrow_water_flow", found.casting.schedule.narrow_water_flow, "");
  increasing(found, "schedule.casting_speed_factor", found.casting.schedule.casting_speed_factor,
             "");
  increasing(found, "schedule.water_flow_factor", found.casting.schedule.water_flow_factor, "");
  increasing(found, "section.half_thickness", found.casting.section.half_thickness, "m");
  increasing(found, "time.step", found.casting.time.step, "s");
  increasing(found, "alloy.density", found.casting.alloy.density, "degC");
  increasing(found, "alloy.specific_heat", found.casting.alloy.specific_heat, "degC");
  increasing(found, "alloy.conductivity", found.casting.alloy.conductivity, "degC");
  increasing(found, "alloy.liquid_fraction", found.casting.alloy.liquid_fraction, "degC");
  increasing(found, "alloy.young_modulus", found.casting.alloy.young_modulus, "degC");
  increasing(found, "alloy.poisson_ratio", found.casting.alloy.poisson_ratio, "degC");
  increasing(found, "cooling.bottom_block.contact_coefficient",
             found.casting.cooling.bottom_block.contact_coefficient, "s");
  increasing(found, "cooling.bottom_block.gap_coefficient",
             found.casting.cooling.bottom_block.gap_coefficient, "m");
  increasing(found, "cooling.bottom_block.profile_x", found.casting.cooling.bottom_block.profile_x,
             "m");
  increasing(found, "cooling.bottom_block.profile_y", found.casting.cooling.bottom_block.profile_y,
             "m");
}

namespace {

bool is_mechanical(const Case& c, double time) {
  return c.mechanics.enabled && time >= c.mechanics.start - 1e-9;
}

/// Integrates the cast length. For speeds against time any leap is exact; other speeds need
/// intermediate steps.
double cast_length(const CastingSchedule& schedule, double length, double time, const Leap& leap) {
  constexpr std::int64_t enough = 1000;
  const std::int64_t pieces = schedule.speed_follows_time() ? 1 : std::min(leap.steps, enough);
  const double piece = (leap.to - time) / static_cast<double>(pieces);
  for (std::int64_t i = 0; i < pieces; ++i) {
    length = schedule.cast_length(length, time + static_cast<double>(i) * piece, piece);
  }
  return length;
}

}  // namespace

void check_time(CaseFindings& found) {
  if (found.sound({"time.end", "schedule.hold"}) &&
      found.casting.time.end <= -found.casting.schedule.hold) {
    found.fault(
        "time.end", with_unit(found.casting.time.end, "s"), "is not after the beginning",
        "more than " + with_unit(-found.casting.schedule.hold, "s") + ", minus schedule.hold",
        "move the end");
  }
  const Schedule& schedule = found.casting.schedule;
  if (schedule.filling > 0.0 && found.sound({"schedule.filling", "schedule.hold"})) {
    const std::string hold = "at most schedule.hold = " + with_unit(schedule.hold, "s");
    if (schedule.filling > schedule.hold)
      found.fault("schedule.filling", with_unit(schedule.filling, "s"),
                  "is longer than the hold, of which it is the beginning", hold,
                  "lengthen the hold: it lasts from the first metal until the block starts");
    else if (!found.casting.section.growth && found.sound({"mesh.growth"}))
      found.fault("schedule.filling", with_unit(schedule.filling, "s"),
                  "fills a slab that does not grow", "0 s with mesh.growth = false",
                  "leave it out");
    else if (found.casting.mechanics.enabled && found.sound({"mechanics.start"}) &&
             found.casting.mechanics.start < schedule.filling - schedule.hold)
      found.fault("mechanics.start", with_unit(found.casting.mechanics.start, "s"),
                  "lies before the mould is full",
                  "at least schedule.filling - schedule.hold = " +
                      with_unit(schedule.filling - schedule.hold, "s"),
                  "start the mechanics later");
  }
  if (!found.sound({"time.step", "time.minimum_step"})) return;
  const auto& steps = found.casting.time.step.value();
  const double shortest = *std::min_element(steps.begin(), steps.end());
  if (found.casting.time.minimum_step > shortest) {
    found.fault("time.minimum_step", with_unit(found.casting.time.minimum_step, "s"),
                "is longer than the shortest step", "at most " + with_unit(shortest, "s"),
                "choose a smaller minimum, such as a hundredth of the step");
  }
}

void check_mechanics(CaseFindings& found) {
  const auto& p = found.casting.mechanics.options.parameters;
  const double product = p.lambda_p.value_or(0.5 / p.gamma_p) * p.gamma_p;
  if (found.casting.mechanics.options.algorithm == mechanics::Algorithm::sbm &&
      found.sound({"mechanics.parameters.gamma_p", "mechanics.parameters.lambda_p"}) &&
      product >= 1.0) {
    found.fault("mechanics.parameters.lambda_p", p.lambda_p.value_or(0.0),
                "times gamma_p is not below 1 (Lemma 3)", "less than 1 / gamma_p",
                "leave it out to take 1 / (2 gamma_p)");
  }
  if (found.casting.mechanics.options.kinematics == mechanics::Kinematics::corotational &&
      found.sound({"section.kind"}) && found.axisymmetric()) {
    found.fault("mechanics.kinematics", "corotational",
                "elements of a billet do not follow their rotation",
                "small_strain with section.kind = \"axisymmetric\"", "leave it out");
  }
}

/// Steps, and how high the metal ends.
void check_course(CaseFindings& found) {
  if (!found.sound(course_keys)) return;
  const CastingSchedule schedule(found.casting);
  double time = schedule.begin(), last = time, length = 0.0;
  std::int64_t steps = 0;
  while (time < schedule.end() - 1e-9 && steps <= found.casting.limits.maximum_steps) {
    const Leap leap = schedule.leap(time);
    length = cast_length(schedule, length, time, leap);
    if (is_mechanical(found.casting, time)) found.mechanical_steps += leap.steps;
    steps += leap.steps;
    last = std::exchange(time, leap.to);
  }
  if (steps > found.casting.limits.maximum_steps) {
    found.fault(
        "time.step", with_unit(found.casting.time.step(last), "s"), "leads to too many time steps",
        "at most limits.maximum_steps = " + std::to_string(found.casting.limits.maximum_steps),
        "lengthen the steps or shorten the simulation");
    return;
  }
  found.final_level =
      found.casting.section.initial_depth + (found.casting.section.growth ? length : 0.0);
  found.estimate.steps = steps;
}

void check_zones(CaseFindings& found) {
  for (std::size_t i = 0; i < found.casting.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = found.casting.cooling.zones[i];
    const std::string field = "cooling.zone[" + std::to_string(i) + "]";
    if (!found.sound({field + ".from", field + ".to"})) continue;
    if (zone.to <= zone.from) {
      found.fault(
          field + ".to", with_unit(zone.to, "m"), "does not lie below the zone's upper edge",
          "more than " + field + ".from = " + with_unit(zone.from, "m"), "exchange from and to");
    }
    for (std::size_t j = 0; j < i; ++j) {
      const thermal::SideZone& other = found.casting.cooling.zones[j];
      if (!found.sound({"cooling.zone[" + std::to_string(j) + "]"})) continue;
      if (zone.face && other.face && *zone.face != *other.face) continue;
      if (zone.from < other.to - 1e-12 && other.from < zone.to - 1e-12) {
        found.fault(field + ".from", with_unit(zone.from, "m"),
                    "overlaps the zone '" + other.name + "'",
                    "bands that do not overlap; that zone ends at " + with_unit(other.to, "m"),
                    "move the edge");
      }
    }
  }
}

}  // namespace dccast::casting
