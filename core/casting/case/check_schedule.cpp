#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/case/checks.hpp"

namespace dccast::casting {

namespace {

constexpr double largest_speed = 0.1, largest_flow = 0.1;  // [m/s], [m2/s], as in the schema

/// Checks that a factor keeps the quantity that it multiplies within its range.
void check_factor(CaseFindings& found, const std::string& key, const Curve& table,
                  const std::string& factor_key, const Curve& factor, double limit,
                  const char* unit) {
  if (table.empty()) return;
  const double largest = std::ranges::max(factor.value());
  if (largest <= 1.0 || !found.sound({key, factor_key})) return;
  const double product = std::ranges::max(table.value()) * largest;
  if (product > limit)
    found.fault(factor_key, largest, "leads to " + with_unit(product, unit) + " with " + key,
                "products of at most " + with_unit(limit, unit), "choose a smaller factor");
}

/// Checks that a table against cast length is not delayed in time.
void check_shift(CaseFindings& found, const std::string& key, const Curve& table, double shift) {
  if (shift == 0.0 || table.empty() || !found.sound({key, key + "_shift"})) return;
  if (table.abscissa() == Abscissa::cast_length)
    found.fault(key + "_shift", with_unit(shift, "s"),
                "moves a table against time, and " + key + " stands against cast length",
                "0 s with a table against cast length", "move the points of the table instead");
}

/// Checks the pulses of a face's water: a valve must not move faster than time can be resolved.
void check_pulses(CaseFindings& found, const std::string& key, const thermal::Water& water) {
  const Case& c = found.casting;
  if (water.pulse_period <= 0.0 || !water.enabled) return;
  if (!found.sound({key + ".pulse_period", key + ".pulse_share", key + ".pulse_end", key + ".start",
                    "time.minimum_step", "time.end"}))
    return;

  // The shorter of the open and the closed part must last a time step.
  const double share = std::min(water.pulse_share, 1.0 - water.pulse_share);
  const std::string period = with_unit(water.pulse_period, "s");
  if (water.pulse_period * (share > 0.0 ? share : 1.0) < c.time.minimum_step)
    found.fault(key + ".pulse_period", period,
                "opens or closes the valve for less than the smallest time step",
                "parts of at least time.minimum_step = " + with_unit(c.time.minimum_step, "s"),
                "lengthen the period");

  const double last = std::min(water.pulse_end, c.time.end);
  const double changes = 2.0 * (last - water.start) / water.pulse_period;
  if (changes > static_cast<double>(c.limits.maximum_steps))
    found.fault(
        key + ".pulse_period", period, "moves the valve more often than there are time steps",
        "at most limits.maximum_steps = " + std::to_string(c.limits.maximum_steps) + " times",
        "lengthen the period or end the pulses earlier");

  if (water.pulse_end <= water.start)
    found.warning(key + ".pulse_end", with_unit(water.pulse_end, "s"),
                  "does not lie after the water's start, so that nothing is pulsed",
                  "more than " + key + ".start = " + with_unit(water.start, "s"),
                  "give the time until which the water is pulsed");
}

/// Checks that the second water lies below the first, and that both of its parts are there.
void check_second_water(CaseFindings& found) {
  const auto& second = found.casting.cooling.second_water;
  const bool has_flow = !found.casting.schedule.second_water_flow.empty();
  if (!second && has_flow)
    return found.fault("schedule.second_water_flow", "given", "has no place where it meets a face",
                       "with cooling.second_water.from", "give the place");
  if (second && !has_flow && found.sound({"schedule.second_water_flow"}))
    return found.fault("cooling.second_water", "given", "has no flow",
                       "with schedule.second_water_flow", "give the flow");
  if (!second || !found.sound({"cooling.second_water.from"})) return;

  for (const auto& [key, face] : {std::pair("cooling.water.from", thermal::Face::wide),
                                  {"cooling.narrow_water.from", thermal::Face::narrow}}) {
    const double line = found.casting.cooling.water_of(face).from;
    if (second->from <= line && found.sound({key}))
      return found.fault("cooling.second_water.from", with_unit(second->from, "m"),
                         "does not lie below the first water",
                         "more than " + std::string(key) + " = " + with_unit(line, "m"),
                         "move it down");
  }
}

/// Checks the plan of the metal level: the block has to sink before the level can.
void check_metal_level(CaseFindings& found) {
  const std::string key = "schedule.metal_level";
  const Case& c = found.casting;
  const Curve& level = c.schedule.metal_level;
  if (level.empty()) return;
  if (!c.section.growth) {
    if (found.sound({"mesh.growth"}))
      found.fault(key, "given", "moves the level of a slab that does not grow",
                  "no metal_level with mesh.growth = false", "leave it out");
    return;
  }
  if (!found.sound({key, "cooling.water.from"})) return;

  if (level(0.0) != 0.0)
    return found.fault(key, with_unit(level(0.0), "m"), "is not 0 when the block starts",
                       "0 m there: section.initial_depth is the depth of the metal then",
                       "begin the table with 0, or change section.initial_depth");
  if (const double least = std::ranges::min(level.value()); least <= -c.cooling.water.from)
    return found.fault(key, with_unit(least, "m"), "lies at or below the water line",
                       "above minus cooling.water.from = " + with_unit(c.cooling.water.from, "m"),
                       "keep the metal in the mould");

  const CastingSchedule plan(c);
  const bool by_length = level.abscissa() == Abscissa::cast_length;
  const auto refuse = [&](double at, double fall, double most) {
    const char* const rate = by_length ? "m per m of cast length" : "m/s";
    found.fault(key, "falls by " + with_unit(fall, rate),
                "is faster than the block sinks, at " + with_unit(at, by_length ? "m" : "s"),
                "at most " + with_unit(most, rate),
                by_length ? "let it fall over more cast length"
                          : "let it fall over more time, or cast faster");
  };

  constexpr double round_off = 1e-9;  // [1]
  constexpr int pieces = 100;         // of a table's section, in which the speed may change
  const std::vector<double>&at = level.at(), &height = level.value();
  for (std::size_t i = 1; i < at.size(); ++i) {
    const double fall = (height[i - 1] - height[i]) / (at[i] - at[i - 1]);
    if (fall <= 0.0) continue;
    if (by_length) {
      if (fall > 1.0 + round_off) return refuse(at[i - 1], fall, 1.0);
      continue;
    }

    // Nothing is held to the plan before the start, nor after the end.
    const double from = std::max(at[i - 1], 0.0), to = std::min(at[i], c.time.end);
    double length = plan.cast_length_over(0.0, 0.0, from, 1000);
    for (int k = 0; k <= pieces && from < to; ++k) {
      const double time = from + (to - from) * k / pieces;
      const double speed = plan.planned_speed(time, length);
      if (fall > speed * (1.0 + round_off)) return refuse(time, fall, speed);
      length = plan.cast_length(length, time, (to - from) / pieces);
    }
  }
}

/// Cooling keys that require a slab with two faces; check_quarter_slab checks the rest.
void check_faces(CaseFindings& found) {
  const Case& c = found.casting;
  if (found.solid() || !found.sound({"section.kind"})) return;
  const auto narrow_face_only = [&](const std::string& key, const char* value) {
    found.fault(key, value, "names a face, and the section has one side",
                "section.kind = \"quarter_slab\" with a face of its own", "leave it out");
  };
  for (std::size_t i = 0; i < c.cooling.zones.size(); ++i)
    if (const auto& face = c.cooling.zones[i].face)
      narrow_face_only("cooling.zone[" + std::to_string(i) + "].face",
                       *face == thermal::Face::wide ? "wide" : "narrow");
  if (c.cooling.narrow_water) narrow_face_only("cooling.narrow_water", "given");
  if (!c.schedule.narrow_water_flow.empty())
    narrow_face_only("schedule.narrow_water_flow", "given");
}

}  // namespace

void check_levers(CaseFindings& found) {
  const Schedule& s = found.casting.schedule;
  check_factor(found, "schedule.casting_speed", s.casting_speed, "schedule.casting_speed_factor",
               s.casting_speed_factor, largest_speed, "m/s");
  for (const auto& [key, flow] : {std::pair{"schedule.water_flow", &s.water_flow},
                                  {"schedule.narrow_water_flow", &s.narrow_water_flow}})
    check_factor(found, key, *flow, "schedule.water_flow_factor", s.water_flow_factor, largest_flow,
                 "m2/s");

  check_shift(found, "schedule.casting_speed", s.casting_speed, s.casting_speed_shift);
  check_shift(found, "schedule.water_flow", s.water_flow, s.water_flow_shift);

  check_second_water(found);
  check_pulses(found, "cooling.water", found.casting.cooling.water);
  if (found.casting.cooling.narrow_water)
    check_pulses(found, "cooling.narrow_water", *found.casting.cooling.narrow_water);
  check_faces(found);
}

void check_tables(CaseFindings& found) {
  const Case& c = found.casting;
  struct Table {
    const char* key;
    const Curve& curve;
    const char* unit;  ///< of its abscissa
  };

  // Curves interpolate, which needs strictly increasing abscissas. Other tables are checked where
  // they are used.
  std::vector<Table> tables{
      {"schedule.casting_speed", c.schedule.casting_speed, ""},
      {"schedule.casting_temperature", c.schedule.casting_temperature, ""},
      {"schedule.water_flow", c.schedule.water_flow, ""},
      {"schedule.narrow_water_flow", c.schedule.narrow_water_flow, ""},
      {"schedule.casting_speed_factor", c.schedule.casting_speed_factor, ""},
      {"schedule.water_flow_factor", c.schedule.water_flow_factor, ""},
      {"schedule.second_water_flow", c.schedule.second_water_flow, ""},
      {"schedule.metal_level", c.schedule.metal_level, ""},
      {"cooling.water.temperature", c.cooling.water.temperature, ""},
      {"cooling.water.critical_heat_flux_factor", c.cooling.water.critical_heat_flux_factor, ""},
      {"section.half_thickness", c.section.half_thickness, "m"},
      {"time.step", c.time.step, "s"},
      {"alloy.density", c.alloy.density, "degC"},
      {"alloy.specific_heat", c.alloy.specific_heat, "degC"},
      {"alloy.conductivity", c.alloy.conductivity, "degC"},
      {"alloy.liquid_fraction", c.alloy.liquid_fraction, "degC"},
      {"alloy.young_modulus", c.alloy.young_modulus, "degC"},
      {"alloy.poisson_ratio", c.alloy.poisson_ratio, "degC"},
      {"cooling.bottom_block.contact_coefficient", c.cooling.bottom_block.contact_coefficient, "s"},
      {"cooling.bottom_block.gap_coefficient", c.cooling.bottom_block.gap_coefficient, "m"},
      {"cooling.bottom_block.profile_x", c.cooling.bottom_block.profile_x, "m"},
      {"cooling.bottom_block.profile_y", c.cooling.bottom_block.profile_y, "m"}};
  if (const auto& narrow = c.cooling.narrow_water) {
    tables.push_back({"cooling.narrow_water.temperature", narrow->temperature, ""});
    tables.push_back(
        {"cooling.narrow_water.critical_heat_flux_factor", narrow->critical_heat_flux_factor, ""});
  }

  for (const auto& [key, curve, unit] : tables) {
    if (!found.fault_of(key).empty()) continue;  // already reported

    const auto repeated = std::ranges::adjacent_find(curve.at(), std::not_fn(std::less{}));
    if (repeated != curve.at().end())
      found.fault(key, with_unit(*std::next(repeated), unit),
                  "does not lie above the point before it", "strictly increasing first values",
                  "sort the table and remove repeated points");
  }
}

void check_time(CaseFindings& found) {
  const Case& c = found.casting;
  const double begin = -c.schedule.hold, filling = c.schedule.filling;

  if (found.sound({"time.end", "schedule.hold"}) && c.time.end <= begin)
    found.fault("time.end", with_unit(c.time.end, "s"), "is not after the beginning",
                "more than " + with_unit(begin, "s") + ", minus schedule.hold", "move the end");

  if (c.time.cool_down > 0.0 && c.cooling.top == thermal::Top::held)
    found.fault("time.cool_down", with_unit(c.time.cool_down, "s"),
                "needs a metal level that can cool",
                "with cooling.top = \"pouring\" or \"insulated\"", "change cooling.top");

  if (c.time.settled && (!c.mechanics.enabled || c.monitors.empty()))
    found.fault("time.settled", with_unit(*c.time.settled, "m/s"), "needs a curl that can settle",
                "with mechanics.enabled and a [[monitor]]", "leave it out: time.end ends the run");

  if (filling > 0.0 && found.sound({"schedule.filling", "schedule.hold"})) {
    if (filling > c.schedule.hold)
      found.fault("schedule.filling", with_unit(filling, "s"),
                  "is longer than the hold, of which it is the beginning",
                  "at most schedule.hold = " + with_unit(c.schedule.hold, "s"),
                  "lengthen the hold: it lasts from the first metal until the block starts");
    else if (!c.section.growth && found.sound({"mesh.growth"}))
      found.fault("schedule.filling", with_unit(filling, "s"), "fills a slab that does not grow",
                  "0 s with mesh.growth = false", "leave it out");
    else if (c.mechanics.enabled && found.sound({"mechanics.start"}) &&
             c.mechanics.start < begin + filling - same_time)
      found.fault("mechanics.start", with_unit(c.mechanics.start, "s"),
                  "lies before the mould is full",
                  "at least schedule.filling - schedule.hold = " + with_unit(begin + filling, "s"),
                  "start the mechanics later");
  }

  if (!found.sound({"time.step", "time.minimum_step"})) return;
  const double shortest = std::ranges::min(c.time.step.value());
  if (c.time.minimum_step > shortest)
    found.fault("time.minimum_step", with_unit(c.time.minimum_step, "s"),
                "is longer than the shortest step", "at most " + with_unit(shortest, "s"),
                "choose a smaller minimum, such as a hundredth of the step");
}

/// Checks options of algorithms against their conditions of convergence and validity.
void check_mechanics(CaseFindings& found) {
  const mechanics::Options& options = found.casting.mechanics.options;
  const auto& p = options.parameters;

  // The splitting method needs lambda_p gamma_p < 1 (Lemma 3).
  if (options.algorithm == mechanics::Algorithm::sbm &&
      found.sound({"mechanics.parameters.gamma_p", "mechanics.parameters.lambda_p"}) &&
      p.lambda_p.value_or(0.5 / p.gamma_p) * p.gamma_p >= 1.0)
    found.fault("mechanics.parameters.lambda_p", p.lambda_p.value_or(0.0),
                "times gamma_p is not below 1 (Lemma 3)", "less than 1 / gamma_p",
                "leave it out to take 1 / (2 gamma_p)");

  if (options.kinematics == mechanics::Kinematics::corotational && found.sound({"section.kind"}) &&
      found.axisymmetric())
    found.fault("mechanics.kinematics", "corotational",
                "elements of a billet do not follow their rotation",
                "small_strain with section.kind = \"axisymmetric\"", "leave it out");
}

/// Counts the steps of the run and finds the final level of the metal.
void check_course(CaseFindings& found) {
  constexpr double round_off = 1e-9;     // [s]
  constexpr std::int64_t enough = 1000;  // pieces of a leap
  if (!found.sound(course_keys)) return;
  const Case& c = found.casting;
  check_metal_level(found);

  const CastingSchedule schedule(c);
  double time = schedule.begin(), last = time, length = 0.0;
  std::int64_t steps = 0;
  while (time < schedule.end() - round_off && steps <= c.limits.maximum_steps) {
    const Leap leap = schedule.leap(time);
    length = schedule.cast_length_over(length, time, leap.to, std::min(leap.steps, enough));
    if (c.mechanics.enabled && time >= c.mechanics.start - round_off)
      found.mechanical_steps += leap.steps;
    steps += leap.steps;
    last = std::exchange(time, leap.to);
  }

  if (steps > c.limits.maximum_steps)
    return found.fault("time.step", with_unit(c.time.step(last), "s"),
                       "leads to too many time steps",
                       "at most limits.maximum_steps = " + std::to_string(c.limits.maximum_steps),
                       "lengthen the steps or shorten the simulation");

  found.final_level = c.section.initial_depth;
  if (c.section.growth) *found.final_level += length + schedule.metal_level(c.time.end, length);
  found.estimate.steps = steps;
}

void check_zones(CaseFindings& found) {
  const auto& zones = found.casting.cooling.zones;
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const thermal::SideZone& zone = zones[i];
    const std::string field = "cooling.zone[" + std::to_string(i) + "]";

    if (!found.sound({field + ".from", field + ".to"})) continue;

    if (zone.to <= zone.from)
      found.fault(
          field + ".to", with_unit(zone.to, "m"), "does not lie below the zone's upper edge",
          "more than " + field + ".from = " + with_unit(zone.from, "m"), "exchange from and to");

    for (std::size_t j = 0; j < i; ++j) {
      const thermal::SideZone& other = zones[j];
      if (!found.sound({"cooling.zone[" + std::to_string(j) + "]"})) continue;

      const bool apart = zone.face && other.face && *zone.face != *other.face;
      if (!apart && zone.from < other.to - 1e-12 && other.from < zone.to - 1e-12)
        found.fault(field + ".from", with_unit(zone.from, "m"),
                    "overlaps the zone '" + other.name + "'",
                    "bands that do not overlap; that zone ends at " + with_unit(other.to, "m"),
                    "move the edge");
    }
  }
}

}  // namespace dccast::casting
