#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The bottom of a quarter slab in plan, coloured by its distance from the block, as inline SVG.
struct GapMap {
  std::string svg;   ///< empty when the frame has no bottom in three dimensions
  int contacts = 0;  ///< bottom nodes that press on the block
  double largest_gap_m = 0.0;
  double largest_x_m = 0.0, largest_y_m = 0.0;  ///< where that is, in the undeformed slab
};

/// Plan view, x to the right and y up; dots mark nodes in contact, wider ones carry more.
GapMap draw_gap_map(const v1::Frame& frame);

}  // namespace dccast::client::render
