#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/render/picture_view.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The surface of a quarter slab as deformed, coloured by temperature, as inline SVG.
struct SlabPicture {
  struct View {
    std::string name;
    std::string svg;
    PictureView view;  ///< of what stands in its group of class "now"
  };
  std::vector<View> views;  ///< empty when the frame is not one of a quarter slab that fits itself
  double displacement_scale = 1.0;  ///< factor by which displacements are drawn larger
};

/// Draws a frame of hexahedra or tetrahedra from three sides, each as parallel projection: the
/// faces that water meets, from above; the same from below, with the butt; and from inside the
/// slab, where the planes of symmetry show the sump. Faces are painted from back to front.
/// @param range  of the colours; absent: that of the frame
SlabPicture draw_slab(const v1::Frame& frame,
                      const std::optional<ColourRange>& range = std::nullopt);

}  // namespace dccast::client::render
