#pragma once

#include <cstdint>
#include <vector>

#include "core/casting/plausibility/plausibility_state.hpp"
#include "core/casting/run_failure.hpp"
#include "core/casting/validity/validity_state.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/restart/sections.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Everything a run carries from one step to the next: what a rejected step puts back and what a
/// checkpoint keeps. Whatever is not in here must follow from it, or a resumed run would differ.
template <int Dim>
struct RunState {
  std::int64_t step = 0;            ///< accepted steps
  double time = 0.0;                ///< [s]
  double cast_length = 0.0;         ///< [m]
  double next_frame = 0.0;          ///< [s]
  double step_limit = 0.0;          ///< of the step control [s]
  double solver_seconds = 0.0;      ///< [s] of computing so far
  double process_seconds = 0.0;     ///< [s] of all threads so far
  RunFailures failures;             ///< of the steps so far that let the run go on
  std::vector<double> row_heights;  ///< of the built-in mesh [m]; empty for an imported one
  thermal::HeatField heat;
  mechanics::SlabState<Dim> slab;
  ValidityState validity;
  PlausibilityState plausibility;
};

/// A state as the sections of a checkpoint, and back. The lengths of the arrays remain to be held
/// against the mesh: misfit() of state_fit.hpp.
template <int Dim>
restart::Sections to_sections(const RunState<Dim>& state);
/// @throws std::out_of_range  a section is missing or not what it should be
template <int Dim>
RunState<Dim> state_of(const restart::Sections& sections);

extern template restart::Sections to_sections(const RunState<2>&);
extern template restart::Sections to_sections(const RunState<3>&);
extern template RunState<2> state_of<2>(const restart::Sections&);
extern template RunState<3> state_of<3>(const restart::Sections&);

}  // namespace dccast::casting
