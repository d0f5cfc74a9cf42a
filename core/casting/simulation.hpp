#pragma once

#include <filesystem>

#include "core/casting/case.hpp"
#include "core/casting/run_failure.hpp"
#include "core/casting/step_observer.hpp"

namespace dccast::casting {

/// Where a run keeps its files: `checkpoint.bin`, `results.h5.part`, then `results.h5` and
/// `results.xdmf`, which appear complete or not at all.
struct RunDirectory {
  std::filesystem::path path;
  bool resume = false;  ///< go on from the checkpoint if there is one that can be read
};

/// Runs one case to its end or to where the observer stops it. A disk that is full or a folder that
/// cannot be written is a failure of the run, of kind storage.
/// @throws InvalidCase  a file of the case cannot be read
RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer);

}  // namespace dccast::casting
