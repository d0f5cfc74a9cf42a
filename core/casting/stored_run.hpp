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

/// A checkpoint of this solver and this case, or the reason why there is none. Whether its state
/// fits the run is checked by CastingRun::restore().
struct [[nodiscard]] StoredRun {
  std::optional<restart::Sections> content;
  std::string reason;                ///< why there is no content; empty if there is
  bool other_version = false;        ///< the reason: another version of the solver wrote it
  std::int64_t step = 0;             ///< accepted steps
  std::int64_t journal_records = 0;  ///< steps and frames in the journal at the checkpoint
};

/// Adds the origin to the state of a run; read_stored_run() checks it.
void sign(restart::Sections& state, const CheckpointOrigin& origin);

/// @throws storage::StorageError  the file is there but cannot be read
StoredRun read_stored_run(const std::filesystem::path& checkpoint, const CheckpointOrigin& origin);

}  // namespace dccast::casting
