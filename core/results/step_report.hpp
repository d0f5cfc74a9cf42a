#pragma once

#include <cstdint>
#include <vector>

namespace dccast::results {

/// What happened in one accepted time step; the plain counterpart of StepReport in job.proto.
/// Fields are documented there. All in SI and °C; "per metre" is per metre of face in plane strain,
/// of circumference in an axisymmetric section; of a quarter slab heat and forces are those of the
/// whole quarter [W], [N].
struct StepReport {
  std::int64_t step = 0;
  double time = 0.0;         ///< [s] end of the step; the block starts at 0, a hold is negative
  double time_step = 0.0;    ///< [s]
  double cast_length = 0.0;  ///< [m] travel of the bottom block
  int iterations = 0;
  int heat_iterations = 0;
  int contact_changes = 0;
  int factorizations = 0;
  int solves = 0;
  int failed_attempts = 0;
  /// (monitor, coordinate) [m], by Case::monitors; not a number while its place is not poured yet.
  std::vector<std::vector<double>> monitor_displacement;
  std::vector<double> monitor_temperature;  ///< (monitor) [°C], likewise
  double equilibrium_residual = 0.0;        ///< [1] relative to the forces that act
  double energy_balance_error = 0.0;        ///< [1] relative to the heat that moved
  double wall_heat_flux = 0.0;              ///< [W/m] out of side and bottom
  double bottom_reaction = 0.0;             ///< [N/m] upwards
  double weight = 0.0;                      ///< [N/m]
  double sump_depth = 0.0;                  ///< [m] below the metal level, on the symmetry plane
  double contact_length = 0.0;              ///< [m] of the bottom that stands on the block
  double solver_seconds = 0.0;              ///< [s] of processors so far, of the threads of the run
  double process_seconds = 0.0;  ///< [s] of the processor so far, of all threads of the process
  double progress = 0.0;         ///< [1] 0 to 1, of the simulated time
  std::int64_t nodes = 0;
  std::int64_t elements = 0;
  double mould_exit_temperature = 0.0;  ///< [°C] largest of the surface
  double complementarity_error = 0.0;   ///< [1] against 1 mm and the weight
  double constitutive_residual = 0.0;   ///< [1] relative
  double liquid_pressure_error = 0.0;   ///< [1] relative, on the liquidus front
  bool beyond_validity = false;
  double maximum_rotation = 0.0;  ///< [rad] of a solid element since it solidified
  double bottom_slip = 0.0;       ///< [m] of the butt beyond its thermal contraction
  double side_heat = 0.0;         ///< [W/m] out of the side; of a quarter slab of its wide face [W]
  double narrow_heat = 0.0;       ///< [W] out of the narrow face of a quarter slab
  double bottom_heat = 0.0;       ///< [W/m] into the block
  double contact_area = 0.0;      ///< [m2] of the bottom of a quarter slab that stands on the block
  int conjugate_gradient_iterations = 0;
  double shell_at_exit = 0.0;     ///< [m] least solid of the side at the mould exit, or at the foot
  double bottom_shell = 0.0;      ///< [m] least solid over the bottom
  double mush_strain = 0.0;       ///< [1] largest tensile between coherency and solidus
  int merged_rows = 0;            ///< rows of cells that merging took out in this step
  double merge_mass_error = 0.0;  ///< [1] relative change of the mass by it
  double merge_energy_error = 0.0;       ///< [1] relative change of the heat content by it
  double merge_equilibrium_error = 0.0;  ///< [1] forces it put out of balance, by those that act
  bool operator==(const StepReport&) const = default;
};

}  // namespace dccast::results
