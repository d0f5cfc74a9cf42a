#include "core/casting/monitors.hpp"

#include <algorithm>
#include <cmath>

#include "core/fem/element.hpp"

namespace dccast::casting {

namespace {

// How far outside of the reference cell a point still counts as inside: round-off of the mapping.
constexpr double slack = 1e-9;

std::optional<Place> inside_triangle(const mesh::Mesh2D& mesh, int e, double x, double y) {
  const int* node = mesh.nodes_of(e);
  const double *a = mesh.point(node[0]), *b = mesh.point(node[1]), *c = mesh.point(node[2]);
  const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  const double s = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / twice;
  const double t = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / twice;
  if (s < -slack || t < -slack || s + t > 1.0 + slack) return std::nullopt;
  return Place{e, {1.0 - s - t, s, t, 0.0}};
}

/// Newton on the bilinear map; for the rectangles of the built-in mesh one step is exact.
std::optional<Place> inside_quadrilateral(const mesh::Mesh2D& mesh, int e, double x, double y) {
  const int* node = mesh.nodes_of(e);
  std::array<double, 2> p{};
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto shape = fem::Q1Quadrilateral::shape(p);
    const auto gradient = fem::Q1Quadrilateral::shape_gradient(p);
    double rx = -x, ry = -y, xs = 0, xt = 0, ys = 0, yt = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double* at = mesh.point(node[i]);
      rx += shape[i] * at[0], ry += shape[i] * at[1];
      xs += gradient[i][0] * at[0], xt += gradient[i][1] * at[0];
      ys += gradient[i][0] * at[1], yt += gradient[i][1] * at[1];
    }
    const double determinant = xs * yt - xt * ys;
    const double ds = (rx * yt - ry * xt) / determinant, dt = (ry * xs - rx * ys) / determinant;
    p[0] -= ds, p[1] -= dt;
    if (std::abs(ds) + std::abs(dt) < 1e-13) break;
  }
  if (std::abs(p[0]) > 1.0 + slack || std::abs(p[1]) > 1.0 + slack) return std::nullopt;
  return Place{e, fem::Q1Quadrilateral::shape(p)};
}

/// Nodes of a patch by height, lowest first.
std::vector<int> by_height(const mesh::Mesh2D& mesh, mesh::PatchKind patch) {
  std::vector<int> nodes = mesh::patch_nodes(mesh, patch);
  std::sort(nodes.begin(), nodes.end(),
            [&](int a, int b) { return mesh.point(a)[1] < mesh.point(b)[1]; });
  return nodes;
}

}  // namespace

std::optional<Place> locate(const mesh::Mesh2D& mesh, double x, double y) {
  for (int e = 0; e < mesh.elements(); ++e) {
    const int* node = mesh.nodes_of(e);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      for (int d = 0; d < 2; ++d) {
        low[d] = std::min(low[d], mesh.point(node[i])[d]);
        high[d] = std::max(high[d], mesh.point(node[i])[d]);
      }
    }
    const double margin = slack * (high[0] - low[0] + high[1] - low[1]);
    if (x < low[0] - margin || x > high[0] + margin || y < low[1] - margin || y > high[1] + margin) {
      continue;
    }
    const auto place = mesh.nodes_per_element == 3 ? inside_triangle(mesh, e, x, y)
                                                   : inside_quadrilateral(mesh, e, x, y);
    if (place) return place;
  }
  return std::nullopt;
}

std::array<double, 2> displacement_at(const mesh::Mesh2D& mesh, const Place& place,
                                      std::span<const double> displacement) {
  std::array<double, 2> u{};
  const int* node = mesh.nodes_of(place.element);
  for (std::size_t i = 0; i < std::size_t(mesh.nodes_per_element); ++i) {
    u[0] += place.shape[i] * displacement[2 * std::size_t(node[i])];
    u[1] += place.shape[i] * displacement[2 * std::size_t(node[i]) + 1];
  }
  return u;
}

double side_temperature(const mesh::Mesh2D& mesh, std::span<const double> temperature,
                        double height) {
  const std::vector<int> side = by_height(mesh, mesh::PatchKind::side);
  if (side.empty()) return 0.0;
  std::size_t above = 0;
  while (above < side.size() && mesh.point(side[above])[1] < height) ++above;
  if (above == 0) return temperature[std::size_t(side.front())];
  if (above == side.size()) return temperature[std::size_t(side.back())];
  const int a = side[above - 1], b = side[above];
  const double share = (height - mesh.point(a)[1]) / (mesh.point(b)[1] - mesh.point(a)[1]);
  return (1.0 - share) * temperature[std::size_t(a)] + share * temperature[std::size_t(b)];
}

double sump_depth(const mesh::Mesh2D& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm) {
  const std::vector<int> axis = by_height(mesh, mesh::PatchKind::symmetry);
  for (std::size_t i = axis.size(); i-- > 1;) {
    const double above = temperature[std::size_t(axis[i])];
    const double below = temperature[std::size_t(axis[i - 1])];
    if (above < isotherm) return metal_level - mesh.point(axis[i])[1];
    if (below >= isotherm) continue;
    const double share = (above - isotherm) / (above - below);
    const double top = mesh.point(axis[i])[1], bottom = mesh.point(axis[i - 1])[1];
    return metal_level - (top + share * (bottom - top));
  }
  return metal_level;
}

}  // namespace dccast::casting
