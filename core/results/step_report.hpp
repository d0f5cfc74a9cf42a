#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace dccast::results {

/// What happened in one accepted time step; the plain counterpart of StepReport in job.proto.
/// Fields are documented there. All in SI and °C; "per metre" is per metre of face in plane strain,
/// of circumference in an axisymmetric section.
struct StepReport {
  std::int64_t step = 0;
  double time = 0.0;
  double time_step = 0.0;
  double cast_length = 0.0;
  int iterations = 0;
  int heat_iterations = 0;
  int contact_changes = 0;
  int factorizations = 0;
  int solves = 0;
  int failed_attempts = 0;
  std::vector<std::array<double, 2>> monitor_displacement;  ///< in the order of Case::monitors
  double equilibrium_residual = 0.0;
  double energy_balance_error = 0.0;
  double wall_heat_flux = 0.0;
  double bottom_reaction = 0.0;
  double weight = 0.0;
  double sump_depth = 0.0;
  double contact_length = 0.0;
  double solver_seconds = 0.0;
  double progress = 0.0;
  std::int64_t nodes = 0;
  std::int64_t elements = 0;
  double mould_exit_temperature = 0.0;
  double complementarity_error = 0.0;
  double constitutive_residual = 0.0;
  double liquid_pressure_error = 0.0;
  bool beyond_validity = false;
  double maximum_rotation = 0.0;
  double bottom_slip = 0.0;
  bool operator==(const StepReport&) const = default;
};

}  // namespace dccast::results
