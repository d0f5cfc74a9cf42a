#pragma once

#include <array>
#include <string>
#include <vector>

namespace dccast::client::render {

/// A point of a section or of a drawing.
struct Point {
  double x = 0.0;  ///< [m], in a drawing [view box unit]
  double y = 0.0;  ///< [m], in a drawing [view box unit]
};

/// Two ends of a line.
using Segment = std::array<Point, 2>;

/// Contour line at the value `level` [unit of `value`] of a field that is linear in each triangle,
/// by marching triangles. Corners exactly on the level count as above it, so that no piece appears
/// twice.
std::vector<Segment> isotherm(const std::vector<Point>& node, const std::vector<double>& value,
                              const std::vector<std::array<int, 3>>& triangles, double level);

/// A range of values [any unit] divided into bands of one colour each, from cold blue over violet
/// to hot yellow, with uniform steps of lightness, readable on white and on black.
struct ColourBands {
  /// Lower end of the first band [unit of the field].
  double low = 0.0;
  double high = 1.0;  ///< above low
  int count = 28;

  double level(int band) const { return low + band * (high - low) / count; }
  int band_of(double value) const;  ///< 0 to count - 1, also for a value outside
  std::string colour(int band) const;
};

/// The part of a triangle that lies in one band.
struct BandPiece {
  int band;
  std::vector<Point> outline;  ///< a convex polygon
};

/// Cuts a triangle along the levels of the bands with a linear field, so that no edges of the mesh
/// show in the colours. The pieces cover the triangle without overlap.
std::vector<BandPiece> band_pieces(const std::array<Point, 3>& corner,
                                   const std::array<double, 3>& value, const ColourBands& bands);

/// The bands as a vertical bar with round numbers beside it and `unit` above. Position and height
/// in units of the view box.
std::string colour_bar(const ColourBands& bands, const std::string& unit, double x, double top,
                       double height);

}  // namespace dccast::client::render
