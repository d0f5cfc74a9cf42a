#pragma once

#include <cstddef>
#include <string>

#include "core/casting/case.hpp"
#include "core/casting/casting_schedule.hpp"
#include "core/casting/run_mesh.hpp"
#include "core/casting/run_state.hpp"

namespace dccast::casting {

/// What a state read from a checkpoint is held against.
template <int Dim>
struct RunShape {
  const Case& casting_case;
  const CastingSchedule& schedule;
  const RunMesh<Dim>& mesh;
  double initial_level = 0.0;  ///< [m]
  std::size_t points = 0;      ///< of an element
  std::size_t bottom_nodes = 0;
};

/// Why a state cannot be of a run: an array that does not fit the mesh, a time outside the case;
/// empty when it can. A checksum finds damage; this finds what a checksum cannot, so that a wrong
/// length never becomes a wrong address.
template <int Dim>
std::string misfit(const RunState<Dim>& state, const RunShape<Dim>& run);

extern template std::string misfit(const RunState<2>&, const RunShape<2>&);
extern template std::string misfit(const RunState<3>&, const RunShape<3>&);

}  // namespace dccast::casting
