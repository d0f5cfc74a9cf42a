#pragma once

#include <array>

#include "client/html/frame_surface.hpp"

namespace dccast::client::render {

/// Projection of a picture. The horizontal coordinate in the view box is across[0] x + across[1] y
/// + across[2] z + across[3], the vertical one likewise with `down`, where x, y, z [m] include the
/// magnified displacement; a 2D section has no z.
struct PictureView {
  std::array<double, 4> across{}, down{};  ///< [1/m] and, the last one, [1]; in view box units
  Vector3
      to_viewer{};  ///< direction to the viewer [1], decides which faces hide others; zero in 2D
};

/// The range of temperatures that the colours of a picture cover [°C].
struct ColourRange {
  double low = 0.0, high = 1.0;  ///< [°C]
};

}  // namespace dccast::client::render
