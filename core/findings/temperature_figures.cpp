#include "core/findings/temperature_figures.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dccast::casting {

namespace {

template <int Dim>
double height_of(const mesh::Mesh<Dim>& mesh, int n) {
  return mesh.point(n)[Dim - 1];
}

template <int Dim>
void sort_by_height(const mesh::Mesh<Dim>& mesh, std::vector<int>& nodes) {
  std::sort(nodes.begin(), nodes.end(),
            [&](int a, int b) { return height_of(mesh, a) < height_of(mesh, b); });
}

/// Nodes where most symmetry planes meet, lowest first.
template <int Dim>
std::vector<int> middle_of(const mesh::Mesh<Dim>& mesh) {
  std::vector<int> planes_at(std::size_t(mesh.nodes()), 0);
  int most = 1;
  for (const auto& patch : mesh.patches) {
    if (patch.kind != mesh::PatchKind::symmetry) continue;
    for (const int n : mesh::patch_nodes(patch)) most = std::max(most, ++planes_at[std::size_t(n)]);
  }
  std::vector<int> nodes;
  for (int n = 0; n < mesh.nodes(); ++n) {
    if (planes_at[std::size_t(n)] == most) nodes.push_back(n);
  }
  sort_by_height(mesh, nodes);
  return nodes;
}

/// The largest value at the points where edges of the sides cross a height within their range.
template <int Dim>
double largest_crossing(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height) {
  double largest = -INFINITY;
  const auto cross = [&](int a, int b) {
    const double low = height_of(mesh, a), high = height_of(mesh, b);
    if (low >= height || high < height) return;
    const double share = (height - low) / (high - low);
    largest = std::max(
        largest, (1.0 - share) * temperature[std::size_t(a)] + share * temperature[std::size_t(b)]);
  };
  mesh::for_each_facet(mesh, mesh::PatchKind::side, [&](const auto& facet, const auto&) {
    const std::size_t corners = std::size_t(facet.nodes);
    for (std::size_t i = 0; i < corners; ++i) {
      const int a = facet.node[i], b = facet.node[(i + 1) % corners];
      cross(a, b);
      cross(b, a);
    }
  });
  return largest;
}

/// The largest value of the nodes at one height.
template <int Dim>
double largest_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  std::span<const int> nodes, double height) {
  constexpr double same_height = 1e-9;  // [m]
  double largest = -INFINITY;
  for (const int n : nodes) {
    if (std::abs(height_of(mesh, n) - height) <= same_height)
      largest = std::max(largest, temperature[std::size_t(n)]);
  }
  return largest;
}

}  // namespace

template <int Dim>
double side_temperature(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height) {
  std::vector<int> side = mesh::patch_nodes(mesh, mesh::PatchKind::side);
  if (side.empty()) return 0.0;
  sort_by_height(mesh, side);
  const double lowest = height_of(mesh, side.front()), highest = height_of(mesh, side.back());
  if (lowest >= height) return largest_at(mesh, temperature, side, lowest);
  if (highest < height) return largest_at(mesh, temperature, side, highest);
  return largest_crossing(mesh, temperature, height);
}

template <int Dim>
double sump_depth(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm) {
  const std::vector<int> axis = middle_of(mesh);
  for (std::size_t i = axis.size(); i-- > 1;) {
    const double above = temperature[std::size_t(axis[i])];
    const double below = temperature[std::size_t(axis[i - 1])];
    if (above < isotherm) return metal_level - height_of(mesh, axis[i]);
    if (below >= isotherm) continue;
    const double share = (above - isotherm) / (above - below);
    const double top = height_of(mesh, axis[i]), bottom = height_of(mesh, axis[i - 1]);
    return metal_level - (top + share * (bottom - top));
  }
  return metal_level;
}

template double side_temperature(const mesh::Mesh<2>&, std::span<const double>, double);
template double side_temperature(const mesh::Mesh<3>&, std::span<const double>, double);
template double sump_depth(const mesh::Mesh<2>&, std::span<const double>, double, double);
template double sump_depth(const mesh::Mesh<3>&, std::span<const double>, double, double);

}  // namespace dccast::casting
