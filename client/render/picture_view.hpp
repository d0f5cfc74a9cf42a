#pragma once

#include <array>

#include "client/render/frame_surface.hpp"

namespace dccast::client::render {

/// How a picture places what it draws: coordinates in the view box are
/// across[0] x + across[1] y + across[2] z + across[3], and likewise down, of x, y, z in metres as
/// displaced and magnified; z is absent from a section.
struct PictureView {
  std::array<double, 4> across{}, down{};
  Vector3 to_viewer{};  ///< faces nearer along it hide others; zero for a section
};

/// The range of temperatures that the colours of a picture cover [°C].
struct ColourRange {
  double low = 0.0, high = 1.0;
};

}  // namespace dccast::client::render
