#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/html/picture_view.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The surface of a quarter slab as deformed, coloured by temperature, as inline SVG.
struct SlabPicture {
  struct View {
    std::string name;
    std::string svg;
    PictureView view;  ///< view of its group of class "now"
  };
  std::vector<View> views;          ///< empty if this is not a consistent frame of a quarter slab
  double displacement_scale = 1.0;  ///< magnification of the displacements [1]
};

/// Draws a frame of hexahedra or tetrahedra in three parallel projections: the water-cooled faces
/// from above; the same from below, with the butt; and from inside the slab, where the symmetry
/// planes show the sump. Faces are painted from back to front.
/// @param range  range of the colours; absent: that of the frame
SlabPicture draw_slab(const v1::Frame& frame,
                      const std::optional<ColourRange>& range = std::nullopt);

}  // namespace dccast::client::render
