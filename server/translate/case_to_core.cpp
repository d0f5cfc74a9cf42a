#include "server/translate/case_to_core.hpp"

#include <google/protobuf/util/json_util.h>

#include "core/material/thermal_properties.hpp"
#include "proto/case_file/quality.hpp"
#include "server/translate/case_parts.hpp"

namespace dccast::translate {

namespace {

namespace fs = std::filesystem;

Abscissa abscissa_of(v1::Abscissa abscissa) {
  switch (abscissa) {
    case v1::TIME:
      return Abscissa::time;
    case v1::CAST_LENGTH:
      return Abscissa::cast_length;
    case v1::TEMPERATURE:
      return Abscissa::temperature;
    case v1::GAP:
      return Abscissa::gap;
    case v1::DISTANCE:
      return Abscissa::distance;
    case v1::LIQUID_FRACTION:
      return Abscissa::liquid_fraction;
    default:
      return Abscissa::none;
  }
}

fs::path attached(const std::string& name, const fs::path& attachments) {
  return name.empty() ? fs::path() : attachments / name;
}

mesh::ElementKind element(v1::ElementKind from) {
  switch (from) {
    case v1::P1:
      return mesh::ElementKind::p1;
    case v1::Q1:
      return mesh::ElementKind::q1;
    default:
      return mesh::ElementKind::q1_bending;
  }
}

mesh::SectionKind section_kind(v1::Section::Kind from) {
  switch (from) {
    case v1::Section::AXISYMMETRIC:
      return mesh::SectionKind::axisymmetric;
    case v1::Section::QUARTER_SLAB:
      return mesh::SectionKind::quarter_slab;
    default:
      return mesh::SectionKind::plane_strain;
  }
}

mesh::SectionSpec section(const v1::Case& from, const fs::path& attachments) {
  mesh::SectionSpec to;
  to.kind = section_kind(from.section().kind());
  to.half_width = from.section().half_width_m();
  to.half_thickness = to_core(from.section().half_thickness_m());
  to.corner_radius = from.section().corner_radius_m();
  to.initial_depth = from.section().initial_depth_m();
  const v1::Mesh& mesh = from.mesh();
  to.element = element(mesh.element());
  to.columns = mesh.columns();
  to.rows = mesh.rows();
  to.layers = mesh.layers();
  to.side_cell = mesh.side_cell_m();
  to.wide_side_cell = mesh.wide_side_cell_m();
  to.bottom_cell = mesh.bottom_cell_m();
  if (mesh.has_growth_cell_m()) to.growth_cell = mesh.growth_cell_m();
  to.merging = {mesh.merge_below_m(), mesh.merged_cell_m()};
  to.refinement = mesh.refinement();
  to.file = attached(mesh.file(), attachments);
  to.growth = mesh.growth();
  return to;
}

std::variant<material::NortonHoffConstants, material::ReferenceCreep> creep(const v1::Alloy& from) {
  if (from.has_norton_hoff()) {
    const v1::NortonHoff& law = from.norton_hoff();
    return material::NortonHoffConstants{.material_resistance = law.material_resistance_pa_per_s(),
                                         .shear_limit = law.shear_limit_pa(),
                                         .activation_energy = law.activation_energy_j_per_mol(),
                                         .exponent = law.exponent()};
  }
  const v1::ReferenceCreep& law = from.reference_creep();
  return material::ReferenceCreep{.stress = law.stress_pa(),
                                  .strain_rate = law.strain_rate_per_s(),
                                  .temperature = law.temperature_c(),
                                  .stress_exponent = law.stress_exponent(),
                                  .activation_energy = law.activation_energy_j_per_mol()};
}

/// @pre liquidus, solidus and liquid fraction are in the card
void coherency(const v1::Alloy& from, material::AlloyCard& to) {
  to.coherency = from.liquidus_c();
  if (from.has_coherency_solid_fraction())
    to.coherency = material::coherency_at(to, from.coherency_solid_fraction());
  if (from.has_coherency_c()) to.coherency = from.coherency_c();
}

/// A table of the metal, or solid and liquid weighted by their fractions.
/// @pre liquidus, solidus and liquid fraction are in the card
Curve of_metal(const material::AlloyCard& card, const v1::Curve& table, const v1::Curve& solid,
               double liquid) {
  if (solid.value_size() == 0 || liquid <= 0.0) return to_core(table);
  return material::mixed_by_fraction(card, to_core(solid), liquid);
}

material::AlloyCard alloy(const v1::Alloy& from) {
  material::AlloyCard to;
  to.name = from.card();
  to.liquidus = from.liquidus_c();
  to.solidus = from.solidus_c();
  to.latent_heat = from.latent_heat_j_per_kg();
  to.specific_heat = to_core(from.specific_heat_j_per_kg_k());
  to.melt_conductivity_factor = to_core(from.melt_conductivity_factor());
  to.liquid_fraction = to_core(from.liquid_fraction());
  to.density = of_metal(to, from.density_kg_per_m3(), from.solid_density_kg_per_m3(),
                        from.liquid_density_kg_per_m3());
  to.conductivity = of_metal(to, from.conductivity_w_per_m_k(), from.solid_conductivity_w_per_m_k(),
                             from.liquid_conductivity_w_per_m_k());
  coherency(from, to);
  to.shell = material::coherency_at(to, from.shell_solid_fraction());
  to.young_modulus = to_core(from.young_modulus_pa());
  to.poisson_ratio = to_core(from.poisson_ratio());
  to.creep = creep(from);
  return to;
}

casting::ThermalOptions thermal_options(const v1::Thermal& from, const fs::path& attachments) {
  casting::ThermalOptions to;
  if (from.has_initial_temperature_c()) to.initial_temperature = from.initial_temperature_c();
  to.tolerance = from.tolerance();
  to.maximum_iterations = from.maximum_iterations();
  to.file = attached(from.file(), attachments);
  return to;
}

casting::TimeControl time_control(const v1::TimeControl& from) {
  casting::TimeControl to;
  to.end = from.end_s();
  to.step = to_core(from.step_s());
  to.minimum_step = from.minimum_step_s();
  return to;
}

casting::Plausibility plausibility(const v1::Plausibility& from) {
  casting::Plausibility to;
  to.minimum_superheat = from.minimum_superheat_k();
  to.minimum_shell = from.minimum_shell_m();
  to.maximum_mush_strain = from.maximum_mush_strain();
  to.maximum_sump_share = from.maximum_sump_share();
  if (from.has_least_curl_m()) to.least_curl = from.least_curl_m();
  if (from.has_greatest_curl_m()) to.greatest_curl = from.greatest_curl_m();
  return to;
}

casting::Validity validity(const v1::Validity& from) {
  casting::Validity to;
  if (from.when_lost() == v1::Validity::CONTINUE) to.when_lost = casting::WhenLost::go_on;
  to.maximum_liquid_pressure_error = from.maximum_liquid_pressure_error();
  to.maximum_rotation = from.maximum_rotation_rad();
  to.maximum_slip = from.maximum_slip_m();
  to.minimum_shell = from.minimum_shell_m();
  return to;
}

casting::Monitor monitor(const v1::Monitor& from) {
  casting::Monitor to{.name = from.name(), .x = from.x_m(), .y = from.y_m()};
  if (from.has_z_m()) to.z = from.z_m();
  return to;
}

void small_tables(const v1::Case& from, casting::Case& to) {
  to.coupling.gap_feedback = from.coupling().gap_feedback();
  to.coupling.iterations = from.coupling().iterations();
  to.coupling.deformed_zones = from.coupling().deformed_zones();
  for (const v1::Monitor& each : from.monitor()) to.monitors.push_back(monitor(each));
  to.output.frame_interval = from.output().frame_interval_s();
  to.output.stresses = from.output().stresses();
  to.checkpoint.every_steps = from.checkpoint().every_steps();
  to.checkpoint.every_seconds = from.checkpoint().every_s();
  to.limits.maximum_nodes = from.limits().maximum_nodes();
  to.limits.maximum_steps = from.limits().maximum_steps();
}

}  // namespace

Curve to_core(const v1::Curve& curve) {
  if (curve.value_size() == 0) return {};
  return Curve(abscissa_of(curve.abscissa()), {curve.at().begin(), curve.at().end()},
               {curve.value().begin(), curve.value().end()});
}

casting::Case to_core(const v1::Case& complete, const std::filesystem::path& attachments) {
  casting::Case to;
  to.title = complete.title();
  to.section = section(complete, attachments);
  to.alloy = alloy(complete.alloy());
  if (complete.alloy().has_coherency_solid_fraction())
    to.coherency_solid_fraction = complete.alloy().coherency_solid_fraction();
  to.schedule = schedule_to_core(complete.schedule());
  to.cooling = cooling_to_core(complete.cooling());
  to.thermal = thermal_options(complete.thermal(), attachments);
  to.mechanics = mechanics_to_core(complete);
  to.time = time_control(complete.time());
  to.validity = validity(complete.validity());
  to.plausibility = plausibility(complete.plausibility());
  small_tables(complete, to);
  to.relative_curl_error = case_file::relative_discretisation_error(complete);
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  const auto status =
      google::protobuf::util::MessageToJsonString(complete, &to.source_json, options);
  if (!status.ok()) to.source_json.clear();  // provenance only; a case that came here is printable
  return to;
}

}  // namespace dccast::translate
