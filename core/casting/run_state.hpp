#pragma once

#include <cstdint>
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
  std::int64_t step = 0;    ///< accepted steps
  double time = 0.0;        ///< [s]
  double cast_length = 0.0; ///< [m]
  double next_frame = 0.0;  ///< [s]
  double step_limit = 0.0;  ///< of the step control [s]
  double solver_seconds = 0.0;
  RunFailures failures;             ///< of the steps so far that let the run go on
  std::vector<double> row_heights;  ///< of the built-in mesh [m]; empty for an imported one
  thermal::HeatField heat;
  mechanics::SlabState<2> slab;
  ValidityState validity;
};

/// A state as the sections of a checkpoint, and back.
/// @param fingerprint  of the case: a checkpoint of another case is not taken
results::Sections to_sections(const RunState& state, const std::string& fingerprint);
/// @return false when the sections are not of this case or not complete
bool from_sections(const results::Sections& sections, const std::string& fingerprint,
                   RunState& state);

}  // namespace dccast::casting
