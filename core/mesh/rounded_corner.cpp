#include "core/mesh/rounded_corner.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dccast::mesh {

namespace {

/// Slope of the opening at the narrow face [1].
double end_slope(const Curve& opening, double half_width) {
  if (opening.constant()) return 0.0;
  double before = 0.0;
  for (const double at : opening.at())
    if (at < half_width) before = std::max(before, at);
  return (opening(half_width) - opening(before)) / (half_width - before);
}

}  // namespace

CornerArc::Point CornerArc::point(double at) const {
  return {centre[0] + radius * std::cos(at), centre[1] + radius * std::sin(at)};
}

CornerArc corner_arc(const SectionSpec& spec) {
  const double slope = end_slope(spec.half_thickness, spec.half_width);
  const double length = std::hypot(1.0, slope);
  const double normal_x = -slope / length, normal_y = 1.0 / length;
  const double end = spec.half_thickness(spec.half_width);
  // The centre lies one radius inside of both faces.
  const double y = end - spec.corner_radius * (1.0 - normal_x) / normal_y;
  return {spec.corner_radius,
          {spec.half_width - spec.corner_radius, y},
          std::atan2(normal_y, normal_x)};
}

void round_corner(const CornerArc& arc, const CornerPatch& patch, PlanGrid& grid) {
  const int i0 = patch.column, j0 = patch.layer;
  const int m = grid.columns - 1 - i0, n = grid.layers - 1 - j0;
  const auto put = [&](int i, int j, const CornerArc::Point& p) {
    grid.at(i0 + i, j0 + j)[0] = p[0];
    grid.at(i0 + i, j0 + j)[1] = p[1];
  };
  const double middle = 0.5 * arc.angle;
  for (int i = 0; i <= m; ++i) put(i, n, arc.point(arc.angle + (middle - arc.angle) * i / m));
  for (int j = 0; j <= n; ++j) put(m, j, arc.point(middle * j / n));
  const auto at = [&](int i, int j, int d) { return grid.at(i0 + i, j0 + j)[d]; };
  for (int i = 1; i < m; ++i)
    for (int j = 1; j < n; ++j) {
      const double u = double(i) / m, v = double(j) / n;
      CornerArc::Point p;
      for (int d = 0; d < 2; ++d)
        p[std::size_t(d)] = (1 - u) * at(0, j, d) + u * at(m, j, d) + (1 - v) * at(i, 0, d) +
                            v * at(i, n, d) - (1 - u) * (1 - v) * at(0, 0, d) -
                            u * (1 - v) * at(m, 0, d) - (1 - u) * v * at(0, n, d) -
                            u * v * at(m, n, d);
      put(i, j, p);
    }
}

}  // namespace dccast::mesh
