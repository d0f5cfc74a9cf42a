#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::verification {

/// A line of a plot; a single point is a mark, and few points have a dot each.
struct Curve2D {
  std::string name;
  std::vector<std::pair<double, double>> points;
  double slope = 0.0;  ///< not zero: a reference line of this order instead, from the last point
};

/// Error against size, both positive and logarithmic, as an SVG element.
std::string log_log_svg(const std::string& title, const std::string& x_label,
                        const std::vector<Curve2D>& curves);
/// The same with linear axes.
std::string chart_svg(const std::string& title, const std::string& x_label,
                      const std::vector<Curve2D>& curves);

/// Corners of a polygon in the plane of the picture, y upwards [m].
using Polygon = std::vector<std::array<double, 2>>;

/// Outlines in one colour, the later over the earlier, as an SVG element.
std::string outlines_svg(const std::string& title, const std::vector<Polygon>& polygons);

/// A mesh with a value by element in a diverging colour scale, as an SVG element; the scale begins
/// at zero where no value is negative.
/// @param limit   value of the strongest colour, positive
/// @param unit    shown at the scale
std::string field_svg(const std::string& title, const mesh::Mesh2D& mesh,
                      const std::vector<double>& value, double limit, const std::string& unit);

}  // namespace dccast::verification
