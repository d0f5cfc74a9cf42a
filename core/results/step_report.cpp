#include "core/results/step_report.hpp"

#include <array>
#include <string_view>

namespace dccast::results {

namespace {

using R = StepReport;

const std::array fields{
    HistoryField{"step", "1", "accepted steps, from 1", &R::step},
    HistoryField{"time_s", "s", "end of the step; the block starts at 0", &R::time},
    HistoryField{"time_step_s", "s", "length of the step", &R::time_step},
    HistoryField{"cast_length_m", "m", "travel of the bottom block", &R::cast_length},
    HistoryField{"iterations", "1", "mechanical iterations", &R::iterations},
    HistoryField{"heat_iterations", "1", "iterations of the heat step", &R::heat_iterations},
    HistoryField{"contact_changes", "1", "changes of the contact set", &R::contact_changes},
    HistoryField{"factorizations", "1", "factorised matrices", &R::factorizations},
    HistoryField{"solves", "1", "solved linear systems", &R::solves},
    HistoryField{"conjugate_gradient_iterations", "1", "of all solves of the step",
                 &R::conjugate_gradient_iterations},
    HistoryField{"failed_attempts", "1", "rejected attempts before this step", &R::failed_attempts},
    HistoryField{"equilibrium_residual", "1", "relative residual of equilibrium",
                 &R::equilibrium_residual},
    HistoryField{"complementarity_error", "1", "relative error of the contact conditions",
                 &R::complementarity_error},
    HistoryField{"constitutive_residual", "1", "relative residual of the constitutive law",
                 &R::constitutive_residual},
    HistoryField{"energy_balance_error", "1", "relative error of the heat balance of the step",
                 &R::energy_balance_error},
    HistoryField{"maximum_rotation_rad", "rad",
                 "largest rotation of a solid element since it solidified", &R::maximum_rotation},
    HistoryField{"bottom_slip_m", "m",
                 "slide of the butt over the block beyond thermal contraction", &R::bottom_slip},
    HistoryField{"beyond_validity", "1", "1 from the step in which validity was lost",
                 &R::beyond_validity},
    HistoryField{"wall_heat_flux_w_per_m", "W/m", "heat out of side and bottom", &R::wall_heat_flux,
                 "W"},
    HistoryField{"side_heat_w_per_m", "W/m",
                 "heat out of the side, of a quarter slab its wide face", &R::side_heat, "W"},
    HistoryField{"narrow_heat_w_per_m", "W/m", "heat out of the narrow face of a quarter slab",
                 &R::narrow_heat, "W"},
    HistoryField{"bottom_heat_w_per_m", "W/m", "heat into the bottom block", &R::bottom_heat, "W"},
    HistoryField{"bottom_reaction_n_per_m", "N/m", "upward force of the bottom block",
                 &R::bottom_reaction, "N"},
    HistoryField{"weight_n_per_m", "N/m", "weight of the metal", &R::weight, "N"},
    HistoryField{"sump_depth_m", "m", "coherency isotherm on the symmetry plane below the level",
                 &R::sump_depth},
    HistoryField{"contact_length_m", "m", "part of the bottom in contact with the block",
                 &R::contact_length},
    HistoryField{"contact_area_m2", "m2",
                 "part of a quarter slab's bottom in contact with the block", &R::contact_area},
    HistoryField{"maximum_surface_temperature_at_mould_exit_c", "degC",
                 "hottest surface at the water line", &R::mould_exit_temperature},
    HistoryField{"shell_at_water_line_m", "m",
                 "smallest shell thickness of the side at the water line, or at the butt",
                 &R::shell_at_water_line},
    HistoryField{"least_shell_m", "m",
                 "smallest shell thickness from the end of the mould contact to the water line",
                 &R::least_shell},
    HistoryField{"least_shell_depth_m", "m", "depth of least_shell_m below the metal level",
                 &R::least_shell_depth},
    HistoryField{"shell_begins_m", "m",
                 "mean depth below the metal level at which the side freezes", &R::shell_begins},
    HistoryField{"bottom_shell_m", "m", "smallest shell thickness over the bottom",
                 &R::bottom_shell},
    HistoryField{"mush_strain", "1",
                 "largest tensile strain of metal that is coherent, not yet tough",
                 &R::mush_strain},
    HistoryField{"tear_rate_per_s", "s-1",
                 "viscoplastic strain rate in the window of hot tears, 95th percentile of the "
                 "metal that has left it",
                 &R::tear_rate},
    HistoryField{"tear_rate_centre_per_s", "s-1", "the same at the butt's centre",
                 &R::tear_rate_centre},
    HistoryField{"tear_rate_surface_per_s", "s-1", "the same at the surface just above the block",
                 &R::tear_rate_surface},
    HistoryField{"tear_pressure_pa", "Pa",
                 "pressure drop of the melt that feeds the mush, 95th percentile of the metal "
                 "that has left the window of hot tears",
                 &R::tear_pressure},
    HistoryField{"tear_pressure_centre_pa", "Pa", "the same at the butt's centre",
                 &R::tear_pressure_centre},
    HistoryField{"tear_pressure_surface_pa", "Pa", "the same at the surface just above the block",
                 &R::tear_pressure_surface},
    HistoryField{"pore_volume_m3_per_m", "m3/m",
                 "pores that unfed shrinkage leaves, volume per metre of face", &R::pore_volume,
                 "m3"},
    HistoryField{"merged_rows", "1", "rows of cells removed by merging in this step",
                 &R::merged_rows},
    HistoryField{"merge_mass_error", "1", "relative change of the mass by merging",
                 &R::merge_mass_error},
    HistoryField{"merge_energy_error", "1", "relative change of the heat content by merging",
                 &R::merge_energy_error},
    HistoryField{"merge_equilibrium_error", "1",
                 "forces unbalanced by merging, relative to the acting forces",
                 &R::merge_equilibrium_error},
    HistoryField{"progress", "1", "share of the simulated time", &R::progress},
    HistoryField{"nodes", "1", "nodes of the mesh", &R::nodes},
    HistoryField{"elements", "1", "elements of the mesh", &R::elements},
    HistoryField{"metal_heat_w_per_m", "W/m", "heat of the metal that entered, above 0 degC",
                 &R::metal_heat, "W"},
    HistoryField{"level_heat_w_per_m", "W/m",
                 "heat in through the metal level; negative: lost to the air", &R::level_heat, "W"},
    HistoryField{"stored_heat_w_per_m", "W/m", "heat gained by the slab", &R::stored_heat, "W"},
    HistoryField{
        "water_share", "1",
        "heat taken by the water of the side, of a quarter slab its wide face, relative to "
        "all that heating and evaporating it would take",
        &R::water_share},
    HistoryField{"narrow_water_share", "1", "the same for the narrow face of a quarter slab",
                 &R::narrow_water_share},
    HistoryField{"wetted_share", "1",
                 "share of the side under water, of a quarter slab its wide face, that is not "
                 "under a vapour film",
                 &R::wetted_share},
    HistoryField{"narrow_wetted_share", "1", "the same for the narrow face of a quarter slab",
                 &R::narrow_wetted_share},
    HistoryField{"water_boiled_away", "1", "1 where too little water is left to cover a face",
                 &R::water_boiled_away},
    HistoryField{"water_thrown_off", "1", "1 where a vapour film has thrown the water off a face",
                 &R::water_thrown_off},
    HistoryField{"block_temperature_c", "degC", "mean surface temperature of the bottom block",
                 &R::block_temperature},
    HistoryField{"residual_axial_depth_m", "m",
                 "of a slab that has cooled down: depth below the face at which the axial stress "
                 "changes sign, at half height",
                 &R::residual_axial_depth},
    HistoryField{"residual_hoop_depth_m", "m", "the same of the stress along the face",
                 &R::residual_hoop_depth},
    HistoryField{"residual_tension_pa", "Pa", "greatest principal stress of an element then",
                 &R::residual_tension},
    HistoryField{"elastic_energy_j_per_m3", "J/m3",
                 "stored elastic energy then, mean over the metal", &R::elastic_energy},
    HistoryField{"off_block_curl_m", "m",
                 "of a slab that has cooled down and lies off the block: the curl of output.curl",
                 &R::off_block_curl},
    HistoryField{"saw_off_m", "m", "how far the butt then rises above the plane that it rests on",
                 &R::saw_off},
    HistoryField{"gap_water_share", "1",
                 "heat taken by water that has run under the butt, relative to all that heating "
                 "and evaporating it would take",
                 &R::gap_water_share},
    HistoryField{"gap_wetted_share", "1",
                 "share of the places that this water touches that is not under a vapour film",
                 &R::gap_wetted_share},
    HistoryField{"steam_share", "1",
                 "force of the steam under the butt, relative to the weight of the metal",
                 &R::steam_share},
};

}  // namespace

std::span<const HistoryField> history_fields() {
  return fields;
}

std::string HistoryField::name_in(int dimension) const {
  constexpr std::string_view per_metre = "_per_m";
  const std::string_view full = name;
  const bool shorter = dimension == 3 && solid_unit != nullptr && full.ends_with(per_metre);
  return std::string(shorter ? full.substr(0, full.size() - per_metre.size()) : full);
}

}  // namespace dccast::results
