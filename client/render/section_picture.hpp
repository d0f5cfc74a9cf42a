#pragma once

#include <optional>
#include <string>

#include "client/render/picture_view.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The deformed section with its temperatures and isotherms as inline SVG.
struct SectionPicture {
  std::string svg;                  ///< empty when the frame holds no mesh that can be drawn
  double displacement_scale = 1.0;  ///< factor by which displacements are drawn larger
  PictureView view;                 ///< of what stands in its group of class "now"
};

/// Draws a frame of a plane or axisymmetric section; one of a quarter slab has no picture here, see
/// slab_picture.hpp. Displacements are enlarged by a round factor, so that the largest of the
/// bottom is about a fifteenth of the section's width. Isotherms every 100 °C, and those of
/// liquidus and solidus.
/// @param range  of the colours; absent: that of the frame
SectionPicture draw_section(const v1::Frame& frame,
                            const std::optional<ColourRange>& range = std::nullopt);

/// Whether array sizes and node numbers of a frame in two dimensions fit each other.
bool consistent(const v1::Frame& frame);

}  // namespace dccast::client::render
