#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/restart/sections.hpp"

namespace dccast::casting {

/// What a run must have in common with a checkpoint to continue from it.
struct CheckpointOrigin {
  std::string solver;     ///< solver_identity()
  std::string case_json;  ///< as in the results
};

/// A checkpoint of this solver and this case, or why there is none. Whether its state fits the run
/// is for CastingRun::restore() to say.
struct StoredRun {
  std::optional<restart::Sections> content;
  std::string reason;                ///< in words; empty only with a content
  bool other_version = false;        ///< the reason is that another solver wrote it
  std::int64_t step = 0;             ///< accepted steps
  std::int64_t journal_records = 0;  ///< that the journal held, steps and frames
};

/// Signs the state of a run, for read_stored_run() to know it again.
void sign(restart::Sections& state, const CheckpointOrigin& origin);

/// @throws storage::StorageError  the file is there but cannot be read
StoredRun read_stored_run(const std::filesystem::path& checkpoint, const CheckpointOrigin& origin);

}  // namespace dccast::casting
