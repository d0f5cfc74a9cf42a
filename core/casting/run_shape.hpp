#pragma once

#include <cstddef>
#include <string>

#include "core/casting/case/case.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/run_mesh.hpp"
#include "core/casting/run_state.hpp"

namespace dccast::casting {

/// The run against which a state read from a checkpoint is checked.
template <int Dim>
struct RunShape {
  /// Case, schedule and mesh of the run that is to continue.
  const Case& casting_case;
  const CastingSchedule& schedule;
  const RunMesh<Dim>& mesh;
  std::size_t points = 0;  ///< integration points per element
};

/// Why a state does not belong to a run: an array does not fit the mesh, or a time lies outside the
/// case; empty if it does belong. A checksum only finds damage; this check keeps an array of the
/// wrong length from being read out of bounds.
template <int Dim>
std::string misfit(const RunState<Dim>& state, const RunShape<Dim>& run);

}  // namespace dccast::casting
