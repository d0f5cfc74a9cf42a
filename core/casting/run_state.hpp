#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/run_failure.hpp"
#include "core/casting/validity/validity_state.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/results/sections.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Everything a run carries from one step to the next: what a rejected step puts back and what a
/// checkpoint keeps. Whatever is not in here must follow from it, or a resumed run would differ.
struct RunState {
  std::int64_t step = 0;     ///< accepted steps
  double time = 0.0;         ///< [s]
  double cast_length = 0.0;  ///< [m]
  double next_frame = 0.0;   ///< [s]
  double step_limit = 0.0;   ///< of the step control [s]
  double solver_seconds = 0.0;      ///< [s] of computing so far
  RunFailures failures;             ///< of the steps so far that let the run go on
  std::vector<double> row_heights;  ///< of the built-in mesh [m]; empty for an imported one
  thermal::HeatField heat;
  mechanics::SlabState<2> slab;
  ValidityState validity;
};

/// What a run must have in common with a checkpoint to continue from it.
struct CheckpointOrigin {
  std::string solver;     ///< solver_identity()
  std::string case_json;  ///< as in the results
};

/// A state out of a checkpoint, or why there is none.
struct RestoredState {
  std::optional<RunState> state;
  std::string reason;                ///< in words; empty only with a state
  bool other_version = false;        ///< the reason is that another solver wrote it
  std::int64_t journal_records = 0;  ///< that the journal held, steps and frames
};

/// A state as the sections of a checkpoint, and back. The lengths of the arrays remain to be held
/// against the mesh: SlabRun::misfit().
results::Sections to_sections(const RunState& state, const CheckpointOrigin& origin);
RestoredState from_sections(const results::Sections& sections, const CheckpointOrigin& origin);
/// @throws results::StorageError  the file is there but cannot be read
RestoredState read_state(const std::filesystem::path& checkpoint, const CheckpointOrigin& origin);

}  // namespace dccast::casting
