#pragma once

#include <span>

#include "core/casting/run_state.hpp"
#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/mesh.hpp"
#include "core/results/frame.hpp"

namespace dccast::casting {

/// What a stored instant shows.
template <int Dim>
struct FrameSource {
  const mesh::Mesh<Dim>& mesh;
  const RunState<Dim>& state;
  double metal_level = 0.0;             ///< [m]
  std::span<const int> bottom_node;     ///< in the order of what follows
  std::span<const double> bottom_gap;   ///< [m] open positive
  std::span<const double> bottom_area;  ///< [m2], in 2D [m]
  bool with_stresses = false;
};

/// The fields of an instant. Stresses and strains are the means of each element.
template <int Dim>
results::Frame frame_of(const FrameSource<Dim>& source);

extern template results::Frame frame_of(const FrameSource<2>&);
extern template results::Frame frame_of(const FrameSource<3>&);

}  // namespace dccast::casting
