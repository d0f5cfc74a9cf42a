#pragma once

#include <optional>
#include <string>

#include "client/html/picture_view.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The deformed section with its temperatures and isotherms as inline SVG.
struct SectionPicture {
  std::string svg;                  ///< empty if the frame has no mesh that can be drawn
  double displacement_scale = 1.0;  ///< magnification of the displacements [1]
  PictureView view;                 ///< view of its group of class "now"
};

/// Draws a frame of a plane or axisymmetric section; for quarter slabs see slab_picture.hpp.
/// Displacements are magnified by a round factor, so that the largest one of the bottom is about a
/// fifteenth of the width of the section. Isotherms are drawn every 100 °C and at liquidus and
/// solidus.
/// @param range  range of the colours; absent: that of the frame
SectionPicture draw_section(const v1::Frame& frame,
                            const std::optional<ColourRange>& range = std::nullopt);

/// Whether array sizes and node numbers of a 2D frame are consistent.
bool consistent(const v1::Frame& frame);

}  // namespace dccast::client::render
