#pragma once

#include <array>
#include <optional>
#include <vector>

#include "client/html/frame_surface.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The visible part of a frame: all elements of a 2D section, the outer surface of a quarter slab.
struct FrameSkin {
  std::vector<std::vector<int>> faces;    ///< nodes in order; in 3D anticlockwise from outside
  std::vector<std::array<int, 2>> edges;  ///< of the outline; in 3D the sharp edges of the surface
};

/// Edges between faces that meet at more than 45 degrees in the undeformed slab.
std::vector<std::array<int, 2>> creases_of(const std::vector<SurfaceFace>& surface);

/// @return empty if the arrays of the frame are inconsistent
std::optional<FrameSkin> skin_of(const v1::Frame& frame);

}  // namespace dccast::client::render
