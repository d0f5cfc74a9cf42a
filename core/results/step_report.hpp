#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace dccast::results {

/// Note: worth knowing. Warning: a plant would object. Danger: a plant could not cast it.
enum class Severity { note, warning, danger };

/// Whether a figure is beyond its limit, as far as mesh and time steps tell. Open: the computed one
/// is not, the true one may be. Likely: the computed one is, the true one may not be. Sure: both.
enum class Certainty { open, likely, sure };

/// A figure beyond its limit, or as near to it as its error.
struct Exceedance {
  double time = 0.0;          ///< [s] end of the step
  double value = 0.0;         ///< [unit of the finding]
  std::vector<double> place;  ///< in the undeformed slab [m]; empty if there is none
  bool operator==(const Exceedance&) const = default;
};

/// A finding about a casting that an engineer should know, see message Finding of job.proto.
/// docs/findings.md lists all codes.
struct Finding {
  std::string code;  ///< e.g. "no_superheat"
  Severity severity = Severity::warning;
  std::string message;          ///< one sentence: what it means in practice
  std::optional<double> time;   ///< [s] when first found; absent: follows from the case alone
  std::vector<double> place;    ///< in the undeformed slab [m]; empty if there is none
  std::optional<double> value;  ///< [`unit`] when first found
  std::optional<double> limit;  ///< [`unit`]
  std::string unit;
  std::string key;  ///< key of the case that sets the limit or causes the finding; empty: none does
  /// The figure farthest beyond the limit so far; absent if the finding has no time or no value.
  std::optional<Exceedance> worst = std::nullopt;
  /// Of the worst figure; absent: the error of such a figure was not measured.
  std::optional<Certainty> certainty = std::nullopt;
  /// [`unit`] how far mesh and steps may have put the true figure below and above the worst one
  std::optional<double> lower_error = std::nullopt, upper_error = std::nullopt;
  bool operator==(const Finding&) const = default;
};

/// What came nearest to the limit of a finding, or farthest beyond it, whether or not it was found.
struct Margin {
  std::string code, key;  ///< of the finding
  std::string unit;       ///< of value and limit
  double limit = 0.0;     ///< at that time
  Exceedance worst;       ///< with a finite value
  bool operator==(const Margin&) const = default;
};

/// "note", "warning" or "danger".
inline const char* name_of(Severity severity) {
  constexpr const char* names[] = {"note", "warning", "danger"};
  return names[static_cast<int>(severity)];
}

/// "open", "likely" or "sure".
inline const char* name_of(Certainty certainty) {
  constexpr const char* names[] = {"open", "likely", "sure"};
  return names[static_cast<int>(certainty)];
}

/// The time from which the results of a run are no longer valid (docs/validity.md).
struct ValidityLoss {
  std::string kind;  ///< the same words as for the outcome of a run that stops there, see SCHEMA.md
  std::string message;        ///< one sentence, with time, place, value, limit and its key
  double time = 0.0;          ///< [s] end of the step in which validity was lost
  std::vector<double> place;  ///< coordinates in the undeformed slab [m]
  double value = 0.0;         ///< [`unit`]
  double limit = 0.0;         ///< [`unit`]
  std::string unit;           ///< "m", "rad" or "1"
  bool operator==(const ValidityLoss&) const = default;
};

/// Report of one accepted time step; the plain counterpart of StepReport in job.proto, where the
/// fields are documented. All in SI units and °C. "Per metre" is per metre of face in plane strain
/// and per metre of circumference in an axisymmetric section; for a quarter slab heat and forces
/// are those of the whole quarter [W], [N].
struct StepReport {
  int dimension = 2;  ///< of the mesh
  std::int64_t step = 0;
  double time = 0.0;         ///< [s] end of the step; the block starts at 0, a hold is negative
  double time_step = 0.0;    ///< [s]
  double cast_length = 0.0;  ///< [m] travel of the bottom block
  int iterations = 0;
  /// Iterations and solver calls of the step, rejected attempts included where the name says so.
  int heat_iterations = 0;
  int contact_changes = 0;
  int factorizations = 0;
  int solves = 0;
  int failed_attempts = 0;
  /// (monitor, coordinate) [m], in the order of Case::monitors; NaN until metal reaches the
  /// monitor.
  std::vector<std::vector<double>> monitor_displacement;
  std::vector<double> monitor_temperature;  ///< (monitor) [°C]; NaN until metal reaches the monitor
  double equilibrium_residual = 0.0;        ///< [1] relative to the acting forces
  double energy_balance_error = 0.0;        ///< [1] relative to the heat exchanged
  double wall_heat_flux = 0.0;              ///< [W/m] out of side and bottom
  double bottom_reaction = 0.0;             ///< [N/m] upwards
  double weight = 0.0;                      ///< [N/m]
  double sump_depth = 0.0;                  ///< [m] below the metal level, on the symmetry plane
  double contact_length = 0.0;              ///< [m] length of the bottom in contact with the block
  double solver_seconds = 0.0;              ///< [s] processor time of the run's threads so far
  double process_seconds = 0.0;  ///< [s] processor time of all threads of the process so far
  double progress = 0.0;         ///< [1] 0 to 1, share of the simulated time
  std::int64_t nodes = 0;
  /// Elements of the mesh at the end of the step.
  std::int64_t elements = 0;
  double mould_exit_temperature = 0.0;  ///< [°C] largest surface temperature at the water line
  double complementarity_error = 0.0;   ///< [1] relative to 1 mm and the weight
  double constitutive_residual = 0.0;   ///< [1] relative
  bool beyond_validity = false;
  double maximum_rotation = 0.0;  ///< [rad] largest rotation of an element since it solidified
  double bottom_slip = 0.0;       ///< [m] lateral slip of the butt beyond thermal contraction
  double side_heat = 0.0;         ///< [W/m] out of the side; quarter slab: wide face [W]
  double narrow_heat = 0.0;       ///< [W] out of the narrow face of a quarter slab
  double bottom_heat = 0.0;       ///< [W/m] into the block
  double contact_area = 0.0;      ///< [m2] bottom of a quarter slab in contact with the block
  int conjugate_gradient_iterations = 0;
  double shell_at_water_line = 0.0;  ///< [m] smallest shell thickness there, or at the butt
  /// [m] smallest shell thickness from the end of the mould contact to the water line
  double least_shell = 0.0;
  double least_shell_depth = 0.0;  ///< [m] of it below the metal level
  double shell_begins = 0.0;  ///< [m] mean depth below the metal level at which the side freezes
  double bottom_shell = 0.0;  ///< [m] smallest shell thickness over the bottom
  /// [1] largest tensile strain of metal that is coherent but not yet tough
  double mush_strain = 0.0;
  // Hot tears (docs/findings.md): of all metal that has left the window, at the butt's centre and
  // at the surface just above the block.
  double tear_rate = 0.0;                ///< [1/s] strain rate in the window, 95th percentile
  double tear_rate_centre = 0.0;         ///< [1/s]
  double tear_rate_surface = 0.0;        ///< [1/s]
  double tear_pressure = 0.0;            ///< [Pa] drop of the feeding melt, 95th percentile
  double tear_pressure_centre = 0.0;     ///< [Pa]
  double tear_pressure_surface = 0.0;    ///< [Pa]
  double pore_volume = 0.0;              ///< [m3/m] of unfed shrinkage; quarter slab [m3]
  int merged_rows = 0;                   ///< rows of cells removed by merging in this step
  double merge_mass_error = 0.0;         ///< [1] relative change of the mass by merging
  double merge_energy_error = 0.0;       ///< [1] relative change of the heat content by merging
  double merge_equilibrium_error = 0.0;  ///< [1] forces unbalanced by merging / acting forces
  // Heat balance, mean over the step: metal_heat + level_heat = stored_heat + side_heat +
  // narrow_heat + bottom_heat. [W/m], quarter slab [W]
  double metal_heat = 0.0;   ///< [W/m] of the metal that entered, above 0 °C
  double level_heat = 0.0;   ///< [W/m] in through the metal level; negative: lost to the air
  double stored_heat = 0.0;  ///< [W/m] gained by the slab
  /// [1] heat taken by the side's water, relative to the most it could take
  double water_share = 0.0;
  double narrow_water_share = 0.0;  ///< [1] the same of a quarter slab's narrow face
  double wetted_share = 0.0;  ///< [1] share of the side under water that is not under a vapour film
  double narrow_wetted_share = 0.0;  ///< [1] the same of a quarter slab's narrow face
  bool water_boiled_away = false;    ///< on some face too little water is left to cover it
  bool water_thrown_off = false;     ///< a vapour film has thrown the water off some face
  double block_temperature = 0.0;    ///< [°C] of the block's surface, mean over its area
  // Of a slab that has cooled down, at the end of the run (docs/residual-stress.md), else 0.
  double residual_axial_depth = 0.0;  ///< [m] below the face, where the axial stress changes sign
  double residual_hoop_depth = 0.0;   ///< [m] the same of the stress along the face
  double off_block_curl = 0.0;        ///< [m] of a cold slab off the block; 0 before
  double saw_off = 0.0;               ///< [m] rise of its butt above the plane that it rests on
  double residual_tension = 0.0;      ///< [Pa] greatest principal stress of an element
  double elastic_energy = 0.0;        ///< [J/m3] mean over the metal
  double gap_water_share = 0.0;   ///< [1] heat taken by water under the butt, of the most it could
  double gap_wetted_share = 0.0;  ///< [1] of the places that it touches, not under a vapour film
  double steam_share = 0.0;       ///< [1] force of the steam under the butt, of the weight
  bool operator==(const StepReport&) const = default;
};

/// A number of StepReport that is stored for every step: name in the file, unit and meaning. The
/// journal, the HDF5 writer and the reader all use this one table.
///
/// Units: a real value is in the unit of its field. A value per metre of face in a section is the
/// value of the whole quarter in a quarter slab, and its name has no `_per_m` there.
struct HistoryField {
  const char* name;  ///< dataset below /history, of a section
  const char* unit;
  const char* meaning;
  std::variant<double StepReport::*, int StepReport::*, std::int64_t StepReport::*,
               bool StepReport::*>
      member;

  const char* solid_unit = nullptr;  ///< unit for a quarter slab, if different

  /// Whether the figure is a real number; else it is an integer or a truth value.
  bool real() const { return member.index() == 0; }
  /// Name and unit of the figure, which depend on the dimension: forces and heat of a section are
  /// per metre.
  std::string name_in(int dimension) const;
  const char* unit_in(int dimension) const {
    return dimension == 3 && solid_unit != nullptr ? solid_unit : unit;
  }
};

/// All fields except the monitors, which are arrays, and except `solver_seconds` and
/// `process_seconds`: these depend on the computer, and two runs of a case would not give the same
/// file.
std::span<const HistoryField> history_fields();

/// The value of a field [its unit]; 0 or 1 for a flag.
/// @tparam Number  double for a real field, else an integer type
template <class Number>
Number value_of(const HistoryField& field, const StepReport& report) {
  return std::visit([&](auto member) { return static_cast<Number>(report.*member); }, field.member);
}
/// Sets a field. @param value  [its unit]
template <class Number>
void set_value(const HistoryField& field, StepReport& report, Number value) {
  std::visit(
      [&](auto member) {
        auto& target = report.*member;
        target = static_cast<std::remove_reference_t<decltype(target)>>(value);
      },
      field.member);
}

}  // namespace dccast::results
