#include "server/levers/planned_levers.hpp"

#include <algorithm>

namespace dccast::levers {

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

}  // namespace dccast::levers
