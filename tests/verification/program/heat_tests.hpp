#pragma once

#include "tests/verification/heat/heat_runs.hpp"
#include "tests/verification/program/run_request.hpp"

namespace dccast::verification {

/// The exact solutions of the heat problem by name. `displacement_error` and `stress_error` of
/// their figures are not a number: heat has neither.
Result run_stefan_by_name(const RunRequest& request);
Result run_mushy_stefan_by_name(const RunRequest& request);
Result run_strand_by_name(const RunRequest& request);
Result run_decaying_mode_by_name(const RunRequest& request);

/// Reads a strand: JSON with conductivity_w_per_m_k, speed_m_per_s, length_m, top_temperature_c,
/// bottom_temperature_c and the points temperature_c, enthalpy_j_per_m3.
/// @throws std::invalid_argument  naming file and key, when something is missing or out of order
StrandData read_strand(const std::filesystem::path& file);

}  // namespace dccast::verification
