#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The bottom of a quarter slab in plan, coloured by its distance from the block, as inline SVG.
struct GapMap {
  std::string svg;   ///< empty if the frame has no 3D bottom
  int contacts = 0;  ///< number of bottom nodes in contact with the block
  double largest_gap_m = 0.0;
  double largest_x_m = 0.0, largest_y_m = 0.0;  ///< its place in the undeformed slab [m]
};

/// Plan view, x to the right and y up; dots mark nodes in contact, larger dots carry more load.
GapMap draw_gap_map(const v1::Frame& frame);

}  // namespace dccast::client::render
