#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::verification {

/// A line of a plot with logarithmic axes.
struct Curve2D {
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< both positive
  double slope = 0.0;  ///< not zero: a reference line of this order instead, from the last point
};

/// Error against size, both logarithmic, as an SVG element.
std::string log_log_svg(const std::string& title, const std::string& x_label,
                        const std::vector<Curve2D>& curves);

/// A mesh with a value by element in a diverging colour scale, as an SVG element.
/// @param limit   value of the strongest colour, positive
/// @param unit    shown at the scale
std::string field_svg(const std::string& title, const mesh::Mesh2D& mesh,
                      const std::vector<double>& value, double limit, const std::string& unit);

}  // namespace dccast::verification
