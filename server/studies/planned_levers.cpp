#include "server/studies/planned_levers.hpp"

#include <algorithm>

#include "proto/frames/contraction.hpp"

namespace dccast::studies {

namespace {

/// The run keeps the last value of a lever as long (core/case/lever_record.hpp).
constexpr double longest_gap_s = 10.0;

/// Each lever and curl as it was measured last, at most `longest_gap_s` before the last reading.
v1::Reading last_values(const std::vector<const v1::Reading*>& readings) {
  v1::Reading values;
  for (const v1::Reading* reading : readings) {
    if (reading->time_s() < readings.back()->time_s() - longest_gap_s) continue;

    // A merge adds curls, so that earlier ones of the same gauges are removed first.
    for (const v1::MeasuredCurl& curl : reading->curls()) {
      const auto is_same = [&](const v1::MeasuredCurl& known) {
        return known.monitor() == curl.monitor();
      };
      auto& curls = *values.mutable_curls();
      curls.erase(std::remove_if(curls.begin(), curls.end(), is_same), curls.end());
    }
    values.MergeFrom(*reading);
  }
  return values;
}

/// No water is planned before the case turns it on.
void turn_off_water(v1::Reading& levers) {
  levers.set_water_flow_m2_per_s(0.0);
  if (levers.has_narrow_water_flow_m2_per_s()) levers.set_narrow_water_flow_m2_per_s(0.0);
}

}  // namespace

double PlannedLevers::planned_speed() const {
  if (time_s_ < 0.0) return 0.0;
  return frames::scheduled_value(plan_.casting_speed_m_per_s(), plan_.casting_speed_factor(),
                                 plan_.casting_speed_shift_s(), time_s_, cast_length_m_);
}

double PlannedLevers::planned_flow(const v1::Curve& table) const {
  return frames::scheduled_value(table, plan_.water_flow_factor(), plan_.water_flow_shift_s(),
                                 time_s_, cast_length_m_);
}

void PlannedLevers::follow(const v1::Reading& reading) {
  const double from_s = std::max(time_s_, 0.0);
  time_s_ = reading.time_s();
  if (time_s_ < 0.0) return;

  const double speed =
      reading.has_casting_speed_m_per_s() ? reading.casting_speed_m_per_s() : planned_speed();
  cast_length_m_ += 0.5 * (speed_m_per_s_ + speed) * (time_s_ - from_s);
  speed_m_per_s_ = speed;
}

v1::Reading PlannedLevers::levers() const {
  v1::Reading levers;
  levers.set_time_s(time_s_);
  levers.set_casting_speed_m_per_s(planned_speed());
  levers.set_water_flow_m2_per_s(planned_flow(plan_.water_flow_m2_per_s()));
  if (plan_.has_narrow_water_flow_m2_per_s())
    levers.set_narrow_water_flow_m2_per_s(planned_flow(plan_.narrow_water_flow_m2_per_s()));
  if (!plan_.casting_temperature_c().value().empty())
    levers.set_casting_temperature_c(
        frames::curve_value(plan_.casting_temperature_c(), time_s_, cast_length_m_, 0.0));
  return levers;
}

v1::CastingNow casting_now(const v1::Case& plan, const std::vector<v1::Reading>& readings) {
  v1::CastingNow now;
  PlannedLevers planned(plan.schedule());
  std::vector<const v1::Reading*> measured;
  for (const v1::Reading& reading : readings) {
    if (reading.closes()) {
      now.set_closed(true);
      continue;
    }
    planned.follow(reading);
    measured.push_back(&reading);
  }
  if (measured.empty()) return now;

  *now.mutable_measured() = last_values(measured);
  *now.mutable_planned() = planned.levers();
  const v1::Water& water = plan.cooling().water();
  if (!water.enabled() || now.planned().time_s() < water.start_s())
    turn_off_water(*now.mutable_planned());
  return now;
}

}  // namespace dccast::studies
