#include "core/case/check/checks.hpp"

namespace dccast::casting {

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

}  // namespace dccast::casting
