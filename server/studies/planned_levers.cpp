#include "server/studies/planned_levers.hpp"

#include <algorithm>

namespace dccast::studies {

namespace {

/// The run keeps the last value of a lever as long (core/casting/case/lever_record.hpp).
constexpr double longest_gap_s = 10.0;

/// Each lever and curl as it was measured last.
v1::Reading last_values(const std::deque<v1::Reading>& readings) {
  v1::Reading values;
  for (const v1::Reading& reading : readings) {
    // A merge adds curls, so that earlier ones of the same gauges are removed first.
    for (const v1::MeasuredCurl& curl : reading.curls()) {
      const auto is_same = [&](const v1::MeasuredCurl& known) {
        return known.monitor() == curl.monitor();
      };
      auto& curls = *values.mutable_curls();
      curls.erase(std::remove_if(curls.begin(), curls.end(), is_same), curls.end());
    }
    values.MergeFrom(reading);
  }
  return values;
}

}  // namespace

void PlannedLevers::follow(const v1::Reading& reading) {
  const double from_s = std::max(now_.time_s, 0.0);
  now_.time_s = reading.time_s();
  if (now_.time_s < 0.0) return;

  const double speed = reading.has_casting_speed_m_per_s() ? reading.casting_speed_m_per_s()
                                                           : plan_.speed_m_per_s(now_);
  now_.cast_length_m += 0.5 * (speed_m_per_s_ + speed) * (now_.time_s - from_s);
  speed_m_per_s_ = speed;
}

v1::Reading PlannedLevers::levers() const {
  v1::Reading levers;
  levers.set_time_s(now_.time_s);
  levers.set_casting_speed_m_per_s(plan_.speed_m_per_s(now_));
  levers.set_water_flow_m2_per_s(plan_.flow_m2_per_s(case_file::Face::wide, now_));
  if (plan_.has_narrow_water())
    levers.set_narrow_water_flow_m2_per_s(plan_.flow_m2_per_s(case_file::Face::narrow, now_));
  if (const auto metal = plan_.casting_temperature(); !metal.table.value().empty())
    levers.set_casting_temperature_c(metal.at(now_));
  return levers;
}

void CastingProgress::follow(const v1::Reading& reading) {
  if (reading.closes()) {
    closed_ = true;
    return;
  }
  planned_.follow(reading);
  last_.push_back(reading);
  while (last_.front().time_s() < reading.time_s() - longest_gap_s) last_.pop_front();
}

v1::CastingNow CastingProgress::now() const {
  v1::CastingNow now;
  if (closed_) now.set_closed(true);
  if (last_.empty()) return now;

  *now.mutable_measured() = last_values(last_);
  *now.mutable_planned() = planned_.levers();
  return now;
}

}  // namespace dccast::studies
