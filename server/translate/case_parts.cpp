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
  to.enabled = from.enabled();
  to.from = from.from_m();
  to.start = from.start_s();
  to.temperature = to_core(from.temperature_c());
  to.critical_heat_flux = from.critical_heat_flux_w_per_m2();
  to.film_boiling = from.film_boiling();
  to.film_boiling_coefficient = from.film_boiling_coefficient_w_per_m2_k();
  to.film_boiling_above = from.film_boiling_above_c();
  to.boiling_follows_flow = from.boiling_follows_flow();
  to.wetting = wetting(from.wetting());
  to.pulse_period = from.pulse_period_s();
  to.pulse_share = from.pulse_share();
  to.pulse_end = from.pulse_end_s();
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
  to.dry_coefficient = from.dry_coefficient_w_per_m2_k();
  to.ambient_temperature = from.ambient_temperature_c();
  to.top = top_of(from.top());
  to.level_coefficient = from.level_coefficient_w_per_m2_k();
  return to;
}

namespace {

mechanics::Algorithm algorithm_of(v1::Mechanics::Algorithm algorithm) {
  switch (algorithm) {
    case v1::Mechanics::VNBM:
      return mechanics::Algorithm::vnbm;
    case v1::Mechanics::SBM:
      return mechanics::Algorithm::sbm;
    case v1::Mechanics::NBM:
      return mechanics::Algorithm::nbm;
    default:
      return mechanics::Algorithm::newton;
  }
}

mechanics::Liquid liquid_of(v1::Mechanics::Liquid liquid) {
  switch (liquid) {
    case v1::Mechanics::WEAK:
      return mechanics::Liquid::weak;
    case v1::Mechanics::SOLID:
      return mechanics::Liquid::solid;
    default:
      return mechanics::Liquid::prestressed;
  }
}

/// Absent: corotational where the butt turns by several degrees, in a quarter slab.
mechanics::Kinematics kinematics_of(const v1::Case& from) {
  switch (from.mechanics().kinematics()) {
    case v1::Mechanics::SMALL_STRAIN:
      return mechanics::Kinematics::small_strain;
    case v1::Mechanics::COROTATIONAL:
      return mechanics::Kinematics::corotational;
    default:
      return from.section().kind() == v1::Section::QUARTER_SLAB
                 ? mechanics::Kinematics::corotational
                 : mechanics::Kinematics::small_strain;
  }
}

mechanics::AlgorithmParameters parameters(const v1::AlgorithmParameters& from) {
  mechanics::AlgorithmParameters to;
  to.gamma_p = from.gamma_p_per_pa_s();
  if (from.has_lambda_p_pa_s()) to.lambda_p = from.lambda_p_pa_s();
  to.gamma_c = from.gamma_c_pa_per_m();
  if (from.has_lambda_c_m_per_pa()) to.lambda_c = from.lambda_c_m_per_pa();
  to.relaxation = from.relaxation();
  return to;
}

}  // namespace

casting::MechanicsCase mechanics_to_core(const v1::Case& complete) {
  const v1::Mechanics& from = complete.mechanics();
  casting::MechanicsCase to;
  to.enabled = from.enabled();
  to.start = from.start_s();
  mechanics::Options& options = to.options;
  options.algorithm = algorithm_of(from.algorithm());
  options.kinematics = kinematics_of(complete);
  options.gravity = from.gravity_m_per_s2();
  options.liquid = liquid_of(from.liquid());
  options.liquid_modulus = from.liquid_modulus_pa();
  options.liquid_epsilon = from.liquid_epsilon();
  options.liquid_delta = from.liquid_delta();
  options.liquid_beta = from.liquid_beta();
  options.confinement = from.confinement();
  if (from.hold() == v1::Mechanics::PENALTY)
    options.confinement_by = mechanics::Confinement::penalty;
  options.confinement_stiffness = from.mould_penalty_pa_per_m();
  options.mould_wall = from.mould_wall();
  options.contact = from.contact();
  options.tolerance = from.tolerance();
  if (from.has_maximum_iterations()) options.maximum_iterations = from.maximum_iterations();
  options.parameters = parameters(from.parameters());
  return to;
}

}  // namespace dccast::translate
