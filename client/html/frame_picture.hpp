#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/html/frame_surface.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// A place for drawings of frames, as inline SVG: axes or names of sides, colours, and an empty
/// group of class "now" that the script of frame_slider.hpp draws a frame into.
struct Picture {
  std::string name;  ///< of the view; empty for a section
  std::string svg;
  PictureView view;  ///< of its group of class "now"
};

/// The pictures of a frame: one of a plane or axisymmetric section; of a quarter slab three
/// parallel projections, the water-cooled faces from above, the same from below with the butt, and
/// from inside the slab, where the symmetry planes show the sump.
struct FramePictures {
  std::vector<Picture> pictures{};  ///< empty if arrays of the frame are not consistent
  double displacement_scale = 1.0;  ///< magnification of the displacements [1]
};

/// @param range  range of the colours
FramePictures pictures_of(const v1::Frame& frame, const ColourRange& range);

}  // namespace dccast::client::render
