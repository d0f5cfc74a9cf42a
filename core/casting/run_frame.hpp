#pragma once

#include <span>

#include "core/casting/run_state.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/frame.hpp"

namespace dccast::casting {

/// Input of frame_of(): the mesh, the state and the bottom of a run at one time.
template <int Dim>
struct FrameSource {
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  double metal_level = 0.0;             ///< [m]
  std::span<const int> bottom_node;     ///< nodes of the bottom, the order of the next two arrays
  std::span<const double> bottom_gap;   ///< [m] positive if open
  std::span<const double> bottom_area;  ///< [m2], in 2D [m]
  const material::MechanicalProperties& properties;
  bool with_stresses = false;  ///< and strains
};

/// The fields at one time. Stresses and strains are element means.
template <int Dim>
results::Frame frame_of(const FrameSource<Dim>& source);

extern template results::Frame frame_of(const FrameSource<2>&);
extern template results::Frame frame_of(const FrameSource<3>&);

}  // namespace dccast::casting
