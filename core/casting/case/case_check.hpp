#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/errors.hpp"
#include "core/casting/case/case.hpp"

namespace dccast::casting {

/// Estimated size of a run.
struct Estimate {
  std::int64_t nodes = 0;  ///< at the end
  std::int64_t elements = 0;
  /// Steps, nodes, time and memory that the run is expected to take.
  std::int64_t steps = 0;
  double solver_seconds = 0.0;  ///< [s] rough estimate for one core
  double memory_bytes = 0.0;    ///< [bytes]
};

/// Everything that is wrong with a case beyond the range of a single value: order of tables and
/// temperatures, monitors inside the slab, readable and matching files, limits. Opens the mesh and
/// temperature files. A fault of the case never raises an exception.
struct CheckedCase {
  /// What prevents a run, and what a user should know before it.
  Faults faults;
  Faults warnings;
  Estimate estimate;  ///< only without faults
};
/// @param faulty_keys  keys whose values are already known to be wrong or missing. Checks that
///                     depend on them are skipped, and a warning says so. The same holds for faults
///                     found here.
CheckedCase check(const Case& casting_case, const std::vector<std::string>& faulty_keys = {});

}  // namespace dccast::casting
