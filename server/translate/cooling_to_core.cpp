#include "server/translate/case_parts.hpp"

#include <optional>

#include "server/translate/case_to_core.hpp"

namespace dccast::translate {

namespace {

Curve factor(const v1::Curve& from) {
  return from.value_size() == 0 ? Curve(1.0) : to_core(from);
}

std::optional<thermal::Face> face_of(v1::SideZone::Face face) {
  switch (face) {
    case v1::SideZone::WIDE:
      return thermal::Face::wide;
    case v1::SideZone::NARROW:
      return thermal::Face::narrow;
    default:
      return std::nullopt;
  }
}

thermal::SideZone zone(const v1::SideZone& from) {
  return {.name = from.name(),
          .from = from.from_m(),
          .to = from.to_m(),
          .liquid_coefficient = to_core(from.liquid_coefficient_w_per_m2_k()),
          .solid_coefficient = to_core(from.solid_coefficient_w_per_m2_k()),
          .temperature = to_core(from.temperature_c()),
          .face = face_of(from.face())};
}

thermal::Wetting wetting(const v1::Wetting& from) {
  return {.flow_exponent = from.flow_exponent(),
          .falling_film_share = from.falling_film_share(),
          .jet_length = from.jet_length_m(),
          .rewetting_saturated = from.rewetting_saturated_c(),
          .rewetting_rise = from.rewetting_rise_k(),
          .rewetting_limit = from.rewetting_limit_c(),
          .rewetting_width = from.rewetting_width_k(),
          .lag = from.lag_s(),
          .jet_film_coefficient = from.jet_film_coefficient_w_per_m2_k(),
          .film_coefficient = from.film_coefficient_w_per_m2_k(),
          .throw_off_length = from.throw_off_length_m(),
          .least_flow = from.least_flow_m2_per_s(),
          .evaporation_from = from.evaporation_from_c()};
}

/// Conductivity and heat capacity of the two materials at 200 °C, recalled; docs/bottom-block.md.
std::optional<thermal::BlockBody> body(const v1::BottomBlock& from) {
  if (!from.has_thickness_m()) return std::nullopt;
  const bool steel = from.material() == v1::BottomBlock::STEEL;
  return thermal::BlockBody{.thickness = from.thickness_m(),
                            .conductivity = steel ? 45.0 : 170.0,
                            .heat_capacity = steel ? 4.1e6 : 2.6e6,
                            .cooling_coefficient = from.cooling_coefficient_w_per_m2_k()};
}

thermal::Top top_of(v1::Cooling::Top from) {
  if (from == v1::Cooling::INSULATED) return thermal::Top::insulated;
  return from == v1::Cooling::HELD ? thermal::Top::held : thermal::Top::pouring;
}

thermal::Water water(const v1::Water& from) {
  thermal::Water to;
  if (from.has_enabled()) to.enabled = from.enabled();
  if (from.has_from_m()) to.from = from.from_m();
  if (from.has_start_s()) to.start = from.start_s();
  to.temperature = to_core(from.temperature_c());
  if (from.has_critical_heat_flux_w_per_m2())
    to.critical_heat_flux = from.critical_heat_flux_w_per_m2();
  if (from.has_film_boiling()) to.film_boiling = from.film_boiling();
  if (from.has_film_boiling_coefficient_w_per_m2_k())
    to.film_boiling_coefficient = from.film_boiling_coefficient_w_per_m2_k();
  if (from.has_film_boiling_above_c()) to.film_boiling_above = from.film_boiling_above_c();
  if (from.has_boiling_follows_flow()) to.boiling_follows_flow = from.boiling_follows_flow();
  to.wetting = wetting(from.wetting());
  if (from.has_pulse_period_s()) to.pulse_period = from.pulse_period_s();
  if (from.has_pulse_share()) to.pulse_share = from.pulse_share();
  if (from.has_pulse_end_s()) to.pulse_end = from.pulse_end_s();
  to.coefficient = to_core(from.coefficient_w_per_m2_k());
  return to;
}

}  // namespace

casting::Schedule schedule_to_core(const v1::Schedule& from) {
  return {.hold = from.hold_s(),
          .filling = from.filling_s(),
          .casting_speed = to_core(from.casting_speed_m_per_s()),
          .casting_temperature = to_core(from.casting_temperature_c()),
          .water_flow = to_core(from.water_flow_m2_per_s()),
          .narrow_water_flow = to_core(from.narrow_water_flow_m2_per_s()),
          .casting_speed_factor = factor(from.casting_speed_factor()),
          .water_flow_factor = factor(from.water_flow_factor()),
          .casting_speed_shift = from.casting_speed_shift_s(),
          .water_flow_shift = from.water_flow_shift_s()};
}

thermal::CoolingSpec cooling_to_core(const v1::Cooling& from) {
  thermal::CoolingSpec to;
  for (const v1::SideZone& each : from.zone()) to.zones.push_back(zone(each));
  to.water = water(from.water());
  if (from.has_narrow_water()) to.narrow_water = water(from.narrow_water());
  const v1::BottomBlock& block = from.bottom_block();
  to.bottom_block = {.contact_coefficient = to_core(block.contact_coefficient_w_per_m2_k()),
                     .gap_coefficient = to_core(block.gap_coefficient_w_per_m2_k()),
                     .temperature_factor = to_core(block.temperature_factor()),
                     .temperature = to_core(block.temperature_c()),
                     .body = body(block),
                     .wet_gap = block.wet_gap_m(),
                     .profile_x = to_core(block.profile_x_m()),
                     .profile_y = to_core(block.profile_y_m())};
  if (block.has_wet_coefficient_w_per_m2_k())
    to.bottom_block.wet_coefficient = block.wet_coefficient_w_per_m2_k();
  if (from.has_dry_coefficient_w_per_m2_k()) to.dry_coefficient = from.dry_coefficient_w_per_m2_k();
  if (from.has_ambient_temperature_c()) to.ambient_temperature = from.ambient_temperature_c();
  to.top = top_of(from.top());
  to.level_coefficient = from.level_coefficient_w_per_m2_k();
  return to;
}

}  // namespace dccast::translate
