#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/render/isotherms.hpp"

namespace dccast::client::render {

/// Cold blue over violet to hot yellow; even in lightness, readable on white and on black.
/// @param part  0 to 1, cut off outside
std::string band_colour(double part);

/// A range of values cut into bands of one colour each.
struct ColourBands {
  double low = 0.0;
  double high = 1.0;  ///< above low
  int count = 28;

  double level(int band) const { return low + band * (high - low) / count; }
  int band_of(double value) const;  ///< 0 to count - 1, also for a value outside
  std::string colour(int band) const { return band_colour((band + 0.5) / count); }
};

struct BandPiece {
  int band;
  std::vector<Point> outline;  ///< a convex polygon
};

/// A triangle cut along the levels of the bands, the field being linear in it: no edge of the mesh
/// shows in the colours. The pieces cover the triangle without overlap.
std::vector<BandPiece> band_pieces(const std::array<Point, 3>& corner,
                                   const std::array<double, 3>& value, const ColourBands& bands);

/// The bands as an upright bar with round figures beside it; `unit` stands above.
std::string colour_bar(const ColourBands& bands, const std::string& unit, double x, double top,
                       double height);

}  // namespace dccast::client::render
