#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/results/checkpoint_file.hpp"

namespace dccast::casting {

/// Identifies the solver: program version, compiler, instruction set of the factorisation,
/// checkpoint format and a digest of the sources of core/. Programs with the same identity continue
/// from a state to bit-identical results; a checkpoint with another identity is not accepted.
const std::string& solver_identity();

/// What a run must have in common with a checkpoint to continue from it.
struct CheckpointOrigin {
  std::string solver;     ///< solver_identity()
  std::string case_json;  ///< as in the results
};

/// A checkpoint of this solver and this case, or the reason why there is none. Whether its state
/// fits the run is checked by CastingRun::restore().
struct [[nodiscard]] StoredRun {
  /// Sections of the checkpoint; absent if there is none that can be used.
  std::optional<results::Sections> content;
  std::string reason;                ///< why there is no content; empty if there is
  bool other_version = false;        ///< the reason: another version of the solver wrote it
  std::int64_t step = 0;             ///< accepted steps
  std::int64_t journal_records = 0;  ///< steps and frames in the journal at the checkpoint
};

/// Adds the origin to the state of a run; read_stored_run() checks it.
void sign(results::Sections& state, const CheckpointOrigin& origin);

/// @throws storage::StorageError  the file is there but cannot be read
StoredRun read_stored_run(const std::filesystem::path& checkpoint, const CheckpointOrigin& origin);

}  // namespace dccast::casting
