#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/casting/case.hpp"
#include "core/casting/run_failure.hpp"
#include "core/casting/step_observer.hpp"

namespace dccast::casting {

/// What to do with a checkpoint that another version of the solver wrote: solver_identity().
enum class OtherVersion { begin_anew, wait, fail };

/// Where a run keeps its files: `checkpoint.bin`, `journal.bin` and `results.h5.part` while it goes
/// on, then `results.h5` and `results.xdmf`, which appear complete or not at all.
struct RunDirectory {
  std::filesystem::path path;
  bool resume = false;  ///< go on from the checkpoint if there is one that can be read
  OtherVersion other_version = OtherVersion::begin_anew;
  /// Last step that the observer has a report of. Those between it and the checkpoint are given to
  /// StepObserver::on_missed_step; none, where this is absent.
  std::optional<std::int64_t> last_reported_step = std::nullopt;
  bool keeps_nothing = false;  ///< no file is written: what the observer hears is all there is
};

/// Runs one case to its end or to where the observer stops it. A disk that is full or a folder that
/// cannot be written is a failure of the run, of kind storage.
/// @param threads  of a quarter slab, at least 1; other sections take one. No number in the results
///                 depends on it, nor does a resumption
/// @throws InvalidCase  a file of the case cannot be read
RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer,
               int threads = 1);

}  // namespace dccast::casting
