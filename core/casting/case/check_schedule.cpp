#include <algorithm>
#include <functional>
#include <utility>

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
  for (const auto& [key, curve, unit] :
       {Table{"schedule.casting_speed", c.schedule.casting_speed, ""},
        Table{"schedule.casting_temperature", c.schedule.casting_temperature, ""},
        Table{"schedule.water_flow", c.schedule.water_flow, ""},
        Table{"schedule.narrow_water_flow", c.schedule.narrow_water_flow, ""},
        Table{"schedule.casting_speed_factor", c.schedule.casting_speed_factor, ""},
        Table{"schedule.water_flow_factor", c.schedule.water_flow_factor, ""},
        Table{"section.half_thickness", c.section.half_thickness, "m"},
        Table{"time.step", c.time.step, "s"}, Table{"alloy.density", c.alloy.density, "degC"},
        Table{"alloy.specific_heat", c.alloy.specific_heat, "degC"},
        Table{"alloy.conductivity", c.alloy.conductivity, "degC"},
        Table{"alloy.liquid_fraction", c.alloy.liquid_fraction, "degC"},
        Table{"alloy.young_modulus", c.alloy.young_modulus, "degC"},
        Table{"alloy.poisson_ratio", c.alloy.poisson_ratio, "degC"},
        Table{"cooling.bottom_block.contact_coefficient",
              c.cooling.bottom_block.contact_coefficient, "s"},
        Table{"cooling.bottom_block.gap_coefficient", c.cooling.bottom_block.gap_coefficient, "m"},
        Table{"cooling.bottom_block.profile_x", c.cooling.bottom_block.profile_x, "m"},
        Table{"cooling.bottom_block.profile_y", c.cooling.bottom_block.profile_y, "m"}}) {
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

  found.final_level = c.section.initial_depth + (c.section.growth ? length : 0.0);
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
