#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_surface.hpp"
#include "client/model/answer.hpp"
#include "client/session/queries.hpp"

namespace dccast::client::render {

/// Projection of a picture. The horizontal coordinate in the view box is across[0] x + across[1] y
/// + across[2] z + across[3], the vertical one likewise with `down`, where x, y, z [m] include the
/// magnified displacement; a 2D section has no z.
struct PictureView {
  std::array<double, 4> across{}, down{};  ///< [1/m] and, the last one, [1]; in view box units
  Vector3 to_viewer{};  ///< direction [1], decides which faces hide others; zero in 2D
};

/// A place for drawings of frames, as inline SVG: axes or names of sides, colours, and an empty
/// group of class "now" that the script of drawn_frames() draws a frame into.
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
FramePictures pictures_of(const v1::Frame& frame, const ColourBands& bands);

/// "250.0 s, cast length 206.7 mm"
std::string when_text(const v1::Frame& frame);

/// Bands over the temperatures of all frames [°C]; empty without one.
std::optional<ColourBands> colour_range(const FrameSeries& series);

/// The frames as data, the script that draws the last one into the groups of class "now" of the
/// preceding pictures, and a slider with which it draws the others. On paper the last frame is
/// shown. Of frames of which one cannot be drawn, or not with the others, only the last is taken;
/// empty if that one cannot be drawn.
/// @param pictures  as pictures_of() the last frame
std::string drawn_frames(const FrameSeries& series, const CurlHistory& history,
                         const FramePictures& pictures);

}  // namespace dccast::client::render
