#pragma once

#include <filesystem>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/casting_run.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// What to do with a checkpoint written by another version of the solver, see solver_identity().
enum class OtherVersion { begin_anew, wait, fail };

/// The file in the directory of a run to which it appends its frames, see results::Journal.
inline constexpr const char* journal_name = "journal.bin";

/// Directory for the files of a run: `checkpoint.bin`, `journal.bin` and `results.h5.part` while it
/// runs, then `results.h5` and `results.xdmf`, which appear complete or not at all.
struct RunDirectory {
  /// Folder, which must exist.
  std::filesystem::path path;
  bool resume = false;  ///< continue from the checkpoint if there is a readable one
  OtherVersion other_version = OtherVersion::begin_anew;
  /// Checkpoint and journal stay after the end of the run too: the caller removes them, once it has
  /// kept how the run ended.
  bool leaves_run_files = false;
  bool keeps_nothing = false;  ///< no file is written; the observer gets the only output
};

/// Runs one case to its end or until the observer stops it. A full disk or a folder that cannot be
/// written is a failure of the run of kind `storage`.
/// @param threads  number of threads for a quarter slab, at least 1; other sections use one. The
///                 results do not depend on it, and a run may be resumed with another number
/// @param feed     of a casting under way: no step goes beyond the last reading, and the run ends
/// with
///                 the record. None: the case alone is computed
/// @throws InvalidCase  a file of the case cannot be read
RunOutcome run(const Case& casting_case, const RunDirectory& directory, StepObserver& observer,
               int threads = 1, LeverFeed* feed = nullptr);

}  // namespace dccast::casting
