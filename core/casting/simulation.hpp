#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/step_observer.hpp"

namespace dccast::casting {

/// Where a run keeps its files: `checkpoint.bin`, `results.h5.part`, then `results.h5` and
/// `results.xdmf`, which appear complete or not at all.
struct RunDirectory {
  std::filesystem::path path;
  bool resume = false;  ///< go on from the checkpoint if there is one that can be read
};

enum class RunEnd { succeeded, solve_failed, check_failed, stopped, cancelled };

struct RunFailure {
  std::string message;
  double time = 0.0;       ///< [s]
  double time_step = 0.0;  ///< [s]
  std::vector<double> residual_history;
};

struct RunOutcome {
  RunEnd end = RunEnd::succeeded;
  std::optional<RunFailure> failure;
};

/// Runs one case to its end or to where the observer stops it.
/// @throws InvalidCase          a file of the case cannot be read
/// @throws std::system_error    the directory cannot be written
RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer);

}  // namespace dccast::casting
