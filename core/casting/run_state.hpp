#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/casting/findings/judge.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/statistics/curl_trace.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// The complete state that a run carries from one step to the next. A rejected step restores it and
/// a checkpoint stores it. Anything else must follow from it, or a resumed run would differ.
template <int Dim>
struct RunState {
  std::int64_t step = 0;         ///< number of accepted steps
  double time = 0.0;             ///< [s]
  double cast_length = 0.0;      ///< [m]
  double next_frame = 0.0;       ///< [s]
  double step_limit = 0.0;       ///< of the step control [s], see StepControl::limit()
  double solver_seconds = 0.0;   ///< [s] computing time of the run so far
  double process_seconds = 0.0;  ///< [s] processor time of all threads so far
  /// [J/m]; billet [J/rad], quarter slab [J]: heat above the liquidus of the metal poured so far,
  /// and heat in through the metal level.
  double superheat = 0.0, level_heat = 0.0;
  statistics::CurlTrace curl;  ///< empty where no case asks whether it has settled
  double settled_at = 0.0;     ///< [s] at which the casting ended before its plan; 0: it did not
  RunFailures failures;        ///< those so far that did not end the run
  std::vector<double> row_heights;  ///< of the built-in mesh [m]; empty for an imported one
  thermal::HeatField heat;
  /// The fields of heat and mechanics, and what the findings remember.
  mechanics::SlabState<Dim> slab;
  FindingsState findings;
};

/// Converts a state to the sections of a checkpoint, and back. Whether the arrays fit the mesh is
/// checked separately: misfit() in run_shape.hpp.
template <int Dim>
results::Sections to_sections(const RunState<Dim>& state);
/// @throws std::out_of_range  a section is missing or has the wrong type
template <int Dim>
RunState<Dim> state_of(const results::Sections& sections);

}  // namespace dccast::casting
