#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/simulation.hpp"

namespace dccast::verification {

/// The case of table 11 and of the comparison of elements, on a mesh of the paper's size.
constexpr const char* casting_name = "start-2d-thickness";
casting::Case shipped_casting(mesh::ElementKind element);

/// What a casting did, from its first step to its end or to where it was given up.
struct CastingRun {
  casting::RunOutcome outcome;
  double seconds = 0.0;  ///< of processor time, files and checks among them
  long iterations = 0, mechanical_steps = 0, failed_attempts = 0;
  results::StepReport last;
  std::vector<double> time_s, curl_m;  ///< by step, of the case's first monitor

  double iterations_per_step() const;
  /// Curl of the first monitor at the last step [mm]; nothing before the first step.
  std::optional<double> curl_mm() const;
  /// In words: its end, or where and why it stopped before.
  std::string ending() const;
};

/// Runs a casting in a scratch directory.
/// @param limit  [s] of processor time after which it is given up
/// @throws std::runtime_error when no scratch directory can be made
CastingRun run_casting(const casting::Case& casting_case, double limit);

}  // namespace dccast::verification
