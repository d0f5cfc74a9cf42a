#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/material/thermal_properties.hpp"
#include "proto/case_file/quality.hpp"
#include "server/translate/enumerations.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {

namespace {

namespace fs = std::filesystem;

/// An optional field. @param is_given  whether the case has it
std::optional<double> given(bool is_given, double value) {
  return is_given ? std::optional(value) : std::nullopt;
}

/// A figure of the alloy that a law may need. @param is_given  whether the case has it
double figure(bool is_given, double value) {
  return is_given ? value : material::not_given;
}

/// Path of an attachment; empty for an empty name.
fs::path attached(const std::string& name, const fs::path& attachments) {
  return name.empty() ? fs::path() : attachments / name;
}

mesh::SectionSpec section(const v1::Case& from, const fs::path& attachments) {
  mesh::SectionSpec to;
  to.kind = to_core(from.section().kind());
  to.half_width = from.section().half_width_m();
  to.half_thickness = to_core(from.section().half_thickness_m());
  to.corner_radius = from.section().corner_radius_m();
  to.initial_depth = from.section().initial_depth_m();
  if (from.cooling().bottom_block().has_bowl()) {
    const v1::Bowl& bowl = from.cooling().bottom_block().bowl();
    to.bowl = {.depth = bowl.depth_m(), .lip = bowl.lip_m(), .wall = bowl.wall_m()};
  }

  const v1::Mesh& mesh = from.mesh();
  to.element = to_core(mesh.element());
  to.columns = mesh.columns();
  to.rows = mesh.rows();
  to.layers = mesh.layers();
  to.heat_cells = {.per_column = std::max(1, mesh.heat_cells_per_column()),
                   .per_layer = std::max(1, mesh.heat_cells_per_layer())};
  to.side_cell = mesh.side_cell_m();
  to.wide_side_cell = mesh.wide_side_cell_m();
  to.bottom_cell = mesh.bottom_cell_m();

  to.growth_cell = given(mesh.has_growth_cell_m(), mesh.growth_cell_m());
  to.merging = {mesh.merge_below_m(), mesh.merged_cell_m()};
  to.refinement = mesh.refinement();

  to.file = attached(mesh.file(), attachments);
  to.growth = mesh.growth();
  return to;
}

std::variant<material::NortonHoffConstants, material::ReferenceCreep> creep(const v1::Alloy& from) {
  if (from.has_norton_hoff()) {
    const v1::NortonHoff& law = from.norton_hoff();
    return material::NortonHoffConstants{
        .material_resistance =
            figure(law.has_material_resistance_pa_per_s(), law.material_resistance_pa_per_s()),
        .shear_limit = figure(law.has_shear_limit_pa(), law.shear_limit_pa()),
        .activation_energy =
            figure(law.has_activation_energy_j_per_mol(), law.activation_energy_j_per_mol()),
        .exponent = figure(law.has_exponent(), law.exponent())};
  }
  const v1::ReferenceCreep& law = from.reference_creep();
  return material::ReferenceCreep{
      .stress = figure(law.has_stress_pa(), law.stress_pa()),
      .strain_rate = figure(law.has_strain_rate_per_s(), law.strain_rate_per_s()),
      .temperature = figure(law.has_temperature_c(), law.temperature_c()),
      .stress_exponent = figure(law.has_stress_exponent(), law.stress_exponent()),
      .activation_energy =
          figure(law.has_activation_energy_j_per_mol(), law.activation_energy_j_per_mol())};
}

/// Laws of the mush. Without a coalescence fraction, the mush is that of the paper.
std::optional<material::MushLaw> mush_law(const v1::Alloy& from) {
  if (!from.has_coalescence_solid_fraction()) return std::nullopt;
  return material::MushLaw{.coalescence = from.coalescence_solid_fraction(),
                           .strength_decay = from.mush_strength_decay(),
                           .unfed_strain_share = from.unfed_strain_share()};
}

/// A table without a yield stress is kept, so that the check of the case sees it.
std::optional<material::ColdStrength> cold_strength(const v1::Alloy& from) {
  const v1::Curve& hardening = from.cold_strength().hardening();
  if (from.cold_strength().yield_stress_pa().value_size() == 0 && hardening.value_size() == 0)
    return std::nullopt;
  return material::ColdStrength{
      .yield_stress = to_core(from.cold_strength().yield_stress_pa()),
      .hardening = hardening.value_size() == 0 ? Curve(0.0) : to_core(hardening)};
}

/// The window ends at coalescence: below it the metal is tough.
material::HotTearWindow hot_tears(const v1::Alloy& from) {
  constexpr double usual_end = 0.98, latest_end = 0.99;  // [1]
  double end = usual_end;
  if (from.has_coalescence_solid_fraction())
    end = std::min(from.coalescence_solid_fraction(), latest_end);
  if (from.has_hot_tear_end_solid_fraction()) end = from.hot_tear_end_solid_fraction();

  return {.start = from.hot_tear_start_solid_fraction(),
          .end = end,
          .arm_spacing = from.arm_spacing_m()};
}

/// Sets the coherency temperature, if the card gives a fraction or a temperature.
/// @pre liquidus, solidus and liquid fraction are set in the card
void set_coherency(const v1::Alloy& from, material::AlloyCard& to) {
  if (from.has_coherency_solid_fraction())
    to.coherency = material::coherency_at(to, from.coherency_solid_fraction());
  if (from.has_coherency_c()) to.coherency = from.coherency_c();
}

bool are_finite(const auto& numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

/// Property of the metal: its table, or solid and liquid weighted by their fractions. Of a case
/// with faults the temperatures may be any numbers.
/// @pre liquidus, solidus and liquid fraction are set in the card
Curve metal_property(const material::AlloyCard& card, const v1::Curve& table,
                     const v1::Curve& solid, double liquid) {
  const bool has_mush = are_finite(std::array{card.solidus, card.liquidus}) &&
                        are_finite(solid.at()) && are_finite(card.liquid_fraction.at());
  if (solid.value_size() == 0 || !(liquid > 0.0) || !has_mush) return to_core(table);
  return material::mixed_by_fraction(card, to_core(solid), liquid);
}

/// Density at the end of feeding: from there on a cell keeps its mass. Empty without a density.
/// @pre density, liquidus, solidus and liquid fraction are set in the card
std::optional<double> fed_density(const v1::Alloy& from, const material::AlloyCard& card) {
  if (card.density.empty()) return std::nullopt;
  const double end =
      from.has_coalescence_solid_fraction() ? from.coalescence_solid_fraction() : 1.0;
  return material::density_at_solid_fraction(card, end);
}

/// Smallest horizontal size of a section [m]: diameter of a billet, thickness of a slab.
double size_across(const mesh::SectionSpec& section) {
  const double half =
      section.half_thickness.empty() ? section.half_width : section.half_thickness(0.0);
  return 2.0 * std::min(half, section.half_width);
}

/// @param size  [m] of the section across, see `size_across`
material::AlloyCard alloy(const v1::Alloy& from, double size) {
  material::AlloyCard to;
  to.name = from.card();
  to.liquidus = figure(from.has_liquidus_c(), from.liquidus_c());
  to.solidus = figure(from.has_solidus_c(), from.solidus_c());
  to.latent_heat = figure(from.has_latent_heat_j_per_kg(), from.latent_heat_j_per_kg());
  to.specific_heat = to_core(from.specific_heat_j_per_kg_k());
  to.melt_conductivity_factor = from.has_melt_stirring()
                                    ? material::melt_stirring(from.melt_stirring(), size)
                                    : to_core(from.melt_conductivity_factor());
  to.liquid_fraction = to_core(from.liquid_fraction());

  // These use liquidus, solidus and liquid fraction, which are set above.
  to.density = metal_property(to, from.density_kg_per_m3(), from.solid_density_kg_per_m3(),
                              from.liquid_density_kg_per_m3());
  to.conductivity =
      metal_property(to, from.conductivity_w_per_m_k(), from.solid_conductivity_w_per_m_k(),
                     from.liquid_conductivity_w_per_m_k());
  set_coherency(from, to);
  if (is_fed(from.cell_mass())) to.fed_density = fed_density(from, to);
  to.shell = material::coherency_at(to, from.shell_solid_fraction());

  to.young_modulus = to_core(from.young_modulus_pa());
  to.poisson_ratio = to_core(from.poisson_ratio());
  to.creep = creep(from);
  to.solid_density = to_core(from.solid_density_kg_per_m3());

  to.mush = mush_law(from);
  to.cold_strength = cold_strength(from);
  to.hot_tears = hot_tears(from);

  return to;
}

Curve factor(const v1::Curve& from) {
  return from.value_size() == 0 ? Curve(1.0) : to_core(from);
}

std::optional<thermal::MouldGap> mould_gap(const v1::SideZone& zone) {
  if (!zone.has_gap()) return std::nullopt;
  return thermal::MouldGap{.air_conductivity = zone.gap().air_conductivity_w_per_m_k(),
                           .emissivity = zone.gap().emissivity(),
                           .taper = zone.gap().taper()};
}

thermal::SideZone zone(const v1::SideZone& from) {
  return {.name = from.name(),
          .from = from.from_m(),
          .to = from.to_m(),
          .liquid_coefficient = to_core(from.liquid_coefficient_w_per_m2_k()),
          .solid_coefficient = to_core(from.solid_coefficient_w_per_m2_k()),
          .temperature = to_core(from.temperature_c()),
          .face = to_core(from.face()),
          .gap = mould_gap(from)};
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

/// The body of the block. Conductivity [W/(m K)] and heat capacity [J/(m^3 K)] of the two materials
/// at 200 °C are recalled; docs/bottom-block.md.
std::optional<thermal::BlockBody> body(const v1::BottomBlock& from) {
  if (!from.has_thickness_m()) return std::nullopt;

  const bool steel = is_steel(from.material());
  return thermal::BlockBody{.thickness = from.thickness_m(),
                            .conductivity = steel ? 45.0 : 170.0,
                            .heat_capacity = steel ? 4.1e6 : 2.6e6,
                            .cooling_coefficient = from.cooling_coefficient_w_per_m2_k()};
}

std::optional<thermal::GapWater> gap_water(const v1::BottomBlock& block) {
  if (!block.has_gap_water()) return std::nullopt;

  const v1::GapWater& from = block.gap_water();
  return thermal::GapWater{.inflow_share = from.inflow_share(),
                           .touching_share = from.touching_share(),
                           .block_coefficient = from.block_coefficient_w_per_m2_k(),
                           .steam_reach = from.steam_reach_m()};
}

thermal::Water water(const v1::Water& from) {
  return {.enabled = from.enabled(),
          .from = from.from_m(),
          .wiped_at = given(from.has_wiped_at_m(), from.wiped_at_m()),
          .start = from.start_s(),
          .temperature = to_core(from.temperature_c()),
          .critical_heat_flux = from.critical_heat_flux_w_per_m2(),
          .critical_heat_flux_factor = factor(from.critical_heat_flux_factor()),
          .boiling_follows_flow = from.boiling_follows_flow(),
          .wetting = wetting(from.wetting()),
          .pulse_period = from.pulse_period_s(),
          .pulse_share = from.pulse_share(),
          .pulse_end = from.pulse_end_s(),
          .coefficient = to_core(from.coefficient_w_per_m2_k())};
}

casting::Schedule schedule(const v1::Schedule& from) {
  return {.hold = from.hold_s(),
          .filling = from.filling_s(),
          .casting_speed = to_core(from.casting_speed_m_per_s()),
          .casting_temperature = to_core(from.casting_temperature_c()),
          .water_flow = to_core(from.water_flow_m2_per_s()),
          .narrow_water_flow = to_core(from.narrow_water_flow_m2_per_s()),
          .casting_speed_factor = factor(from.casting_speed_factor()),
          .water_flow_factor = factor(from.water_flow_factor()),
          .casting_speed_shift = from.casting_speed_shift_s(),
          .water_flow_shift = from.water_flow_shift_s(),
          .second_water_flow = to_core(from.second_water_flow_m2_per_s()),
          .metal_level = to_core(from.metal_level_m())};
}

/// @param first_metal  [s] time at which metal first stands on the block
thermal::CoolingSpec cooling(const v1::Cooling& from, double first_metal) {
  thermal::CoolingSpec to;
  for (const v1::SideZone& each : from.zone()) to.zones.push_back(zone(each));
  to.water = water(from.water());
  if (from.has_narrow_water()) to.narrow_water = water(from.narrow_water());
  if (from.has_second_water())
    to.second_water = {from.second_water().from_m(), from.second_water().start_s()};

  const v1::BottomBlock& block = from.bottom_block();
  to.bottom_block = {.contact_coefficient = to_core(block.contact_coefficient_w_per_m2_k()),
                     .first_metal = first_metal,
                     .gap_coefficient = to_core(block.gap_coefficient_w_per_m2_k()),
                     .temperature_factor = to_core(block.temperature_factor()),
                     .temperature = to_core(block.temperature_c()),
                     .body = body(block),
                     .wet_coefficient = given(block.has_wet_coefficient_w_per_m2_k(),
                                              block.wet_coefficient_w_per_m2_k()),
                     .wet_gap = block.wet_gap_m(),
                     .gap_water = gap_water(block),
                     .profile_x = to_core(block.profile_x_m()),
                     .profile_y = to_core(block.profile_y_m())};

  for (const v1::DrainHole& hole : block.drain_hole())
    to.bottom_block.drain_holes.push_back({hole.x_m(), hole.y_m(), hole.diameter_m()});

  to.dry_coefficient = from.dry_coefficient_w_per_m2_k();
  to.ambient_temperature = from.ambient_temperature_c();
  to.top = to_core(from.top());
  to.level_coefficient = from.level_coefficient_w_per_m2_k();
  return to;
}

/// Kinematics of a case. If it leaves them open: corotational in a quarter slab, whose butt turns
/// by several degrees.
mechanics::Kinematics kinematics(const v1::Case& from) {
  const bool solid = from.section().kind() == v1::Section::QUARTER_SLAB;
  return to_core(from.mechanics().kinematics())
      .value_or(solid ? mechanics::Kinematics::corotational : mechanics::Kinematics::small_strain);
}

mechanics::AlgorithmParameters parameters(const v1::AlgorithmParameters& from) {
  return {.gamma_p = from.gamma_p_per_pa_s(),
          .lambda_p = given(from.has_lambda_p_pa_s(), from.lambda_p_pa_s()),
          .gamma_c = from.gamma_c_pa_per_m(),
          .lambda_c = given(from.has_lambda_c_m_per_pa(), from.lambda_c_m_per_pa()),
          .relaxation = from.relaxation()};
}

/// @param complete  its section decides the kinematics if the case leaves them open
casting::MechanicsCase mechanics_case(const v1::Case& complete) {
  const v1::Mechanics& from = complete.mechanics();
  casting::MechanicsCase to;
  to.enabled = from.enabled();
  to.start = from.start_s();

  mechanics::Options& options = to.options;
  options.algorithm = to_core(from.algorithm());
  options.kinematics = kinematics(complete);
  options.gravity = from.gravity_m_per_s2();

  options.liquid = to_core(from.liquid());
  options.liquid_epsilon = from.liquid_epsilon();
  options.liquid_delta = from.liquid_delta();
  options.liquid_beta = from.liquid_beta();

  options.confinement = true;
  options.confinement_by = to_core(from.hold());
  options.confinement_stiffness = from.mould_penalty_pa_per_m();
  options.contact = from.contact();

  options.tolerance = from.tolerance();
  if (from.has_maximum_iterations()) options.maximum_iterations = from.maximum_iterations();
  options.parameters = parameters(from.parameters());
  return to;
}

casting::Plausibility plausibility(const v1::Plausibility& from) {
  return {.minimum_superheat = from.minimum_superheat_k(),
          .minimum_shell = from.minimum_shell_m(),
          .minimum_meniscus = from.minimum_meniscus_m(),
          .greatest_steam_share = from.greatest_steam_share(),
          .maximum_mush_strain = given(from.has_maximum_mush_strain(), from.maximum_mush_strain()),
          .reference_tear_rate =
              given(from.has_reference_tear_rate_per_s(), from.reference_tear_rate_per_s()),
          .reference_tear_pressure =
              given(from.has_reference_tear_pressure_pa(), from.reference_tear_pressure_pa()),
          .maximum_sump_share = from.maximum_sump_share(),
          .least_curl = given(from.has_least_curl_m(), from.least_curl_m()),
          .greatest_curl = given(from.has_greatest_curl_m(), from.greatest_curl_m())};
}

casting::Validity validity(const v1::Validity& from) {
  return {.when_lost = to_core(from.when_lost()),
          .maximum_rotation = from.maximum_rotation_rad(),
          .maximum_slip = from.maximum_slip_m(),
          .minimum_shell = from.minimum_shell_m()};
}

casting::Monitor monitor(const v1::Monitor& from) {
  casting::Monitor to{.name = from.name(),
                      .x = from.x_m(),
                      .y = from.y_m(),
                      .z = given(from.has_z_m(), from.z_m())};
  for (const v1::MonitorShare& share : from.of())
    to.of.push_back({.monitor = share.monitor(), .weight = share.weight()});
  return to;
}

/// Sets the remaining tables of a case, each of a few fields.
void set_small_tables(const v1::Case& from, casting::Case& to) {
  to.coupling.gap_feedback = from.coupling().gap_feedback();
  to.coupling.iterations = from.coupling().iterations();
  to.coupling.deformed_zones = from.coupling().deformed_zones();

  to.time.end = from.time().end_s();
  to.time.cool_down = from.time().cool_down_s();
  to.time.settled = given(from.time().has_settled_m_per_s(), from.time().settled_m_per_s());
  to.time.step = to_core(from.time().step_s());
  to.time.minimum_step = from.time().minimum_step_s();

  for (const v1::Monitor& each : from.monitor()) to.monitors.push_back(monitor(each));

  to.output.frame_interval = from.output().frame_interval_s();
  to.output.stresses = from.output().stresses();
  to.output.curl = from.output().curl();
  to.checkpoint.every_steps = from.checkpoint().every_steps();
  to.checkpoint.every_seconds = from.checkpoint().every_s();

  to.limits.maximum_nodes = from.limits().maximum_nodes();
  to.limits.maximum_steps = from.limits().maximum_steps();
}

}  // namespace

Curve to_core(const v1::Curve& curve) {
  if (curve.value_size() == 0) return {};
  return Curve(to_core(curve.abscissa()), {curve.at().begin(), curve.at().end()},
               {curve.value().begin(), curve.value().end()});
}

casting::Case to_core(const v1::Case& complete, const std::filesystem::path& attachments) {
  casting::Case to;
  to.title = complete.title();
  to.section = section(complete, attachments);
  to.alloy = alloy(complete.alloy(), size_across(to.section));
  to.coherency_solid_fraction = given(complete.alloy().has_coherency_solid_fraction(),
                                      complete.alloy().coherency_solid_fraction());

  to.schedule = schedule(complete.schedule());
  to.cooling = cooling(complete.cooling(), -to.schedule.hold);

  const v1::Thermal& thermal = complete.thermal();
  to.thermal.tolerance = thermal.tolerance();
  to.thermal.maximum_iterations = thermal.maximum_iterations();
  to.thermal.file = attached(thermal.file(), attachments);

  to.mechanics = mechanics_case(complete);
  to.validity = validity(complete.validity());
  to.plausibility = plausibility(complete.plausibility());
  set_small_tables(complete, to);
  // The result file keeps the larger side of the band.
  if (const auto error = case_file::relative_discretisation_error(complete))
    to.relative_curl_error = std::max(error->lower(), error->upper());
  for (const case_file::FigureBand& band : case_file::figure_bands(complete))
    to.figure_errors[band.figure] = {band.below, band.above, band.is_relative};

  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  const auto status =
      google::protobuf::util::MessageToJsonString(complete, &to.source_json, options);
  if (!status.ok()) to.source_json.clear();  // provenance only, so not worth a failure
  return to;
}

}  // namespace dccast::translate
