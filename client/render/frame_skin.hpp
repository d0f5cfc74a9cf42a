#pragma once

#include <array>
#include <optional>
#include <vector>

#include "client/render/frame_surface.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// What of a frame is seen: of a section all its elements, of a quarter slab its outer surface.
struct FrameSkin {
  std::vector<std::vector<int>> faces;    ///< nodes in order; in 3D anticlockwise from outside
  std::vector<std::array<int, 2>> edges;  ///< of the outline; in 3D where the surface turns
};

/// Edges between faces that turn by more than 45 degrees, in the undeformed slab.
std::vector<std::array<int, 2>> creases_of(const std::vector<SurfaceFace>& surface);

/// @return nothing for a frame whose arrays do not fit each other
std::optional<FrameSkin> skin_of(const v1::Frame& frame);

}  // namespace dccast::client::render
