#include "core/case/check/checks.hpp"

#include <algorithm>
#include <utility>

#include "core/case/casting_schedule.hpp"

namespace dccast::casting {

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

}  // namespace dccast::casting
