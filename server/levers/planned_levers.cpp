#include "server/levers/planned_levers.hpp"

#include <algorithm>

namespace dccast::levers {

void PlannedLevers::follow(const v1::Reading& reading) {
  const double from_s = std::max(now_.time_s, 0.0);
  now_.time_s = reading.time_s();
  if (reading.has_water_temperature_c())
    seen_.set_water_temperature_c(reading.water_temperature_c());
  if (reading.has_metal_level_m()) seen_.set_metal_level_m(reading.metal_level_m());
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
  if (plan_.has_second_water())
    levers.set_second_water_flow_m2_per_s(plan_.second_flow_m2_per_s(now_));
  if (const auto metal = plan_.casting_temperature(); !metal.table.value().empty())
    levers.set_casting_temperature_c(metal.at(now_));

  // Few plants measure these or plan them: others need not see them.
  const auto water = plan_.water_temperature(case_file::Face::wide);
  if (seen_.has_water_temperature_c() || water.table.at_size() > 1)
    levers.set_water_temperature_c(water.at(now_));
  const auto level = plan_.metal_level();
  if (seen_.has_metal_level_m() || level.table.at_size() > 1)
    levers.set_metal_level_m(now_.time_s > 0.0 ? level.at(now_) : 0.0);
  return levers;
}

}  // namespace dccast::levers
