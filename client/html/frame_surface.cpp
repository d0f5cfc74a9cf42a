#include "client/html/frame_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "proto/frames/contraction.hpp"

namespace dccast::client::render {
namespace {

using Local = std::vector<std::vector<int>>;

/// Corners of the faces of an element, in cyclic order.
const Local& faces_of(int nodes_per_element) {
  static const Local tetrahedron{{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};
  static const Local hexahedron{{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  return nodes_per_element == 4 ? tetrahedron : hexahedron;
}

Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Product of the diagonals of a face, or of two sides of a triangle.
Vector3 across(const std::vector<int>& face, const std::vector<Vector3>& place) {
  return cross(minus(place[face[2]], place[face[0]]), minus(place[face.back()], place[face[1]]));
}

Vector3 middle(const std::vector<int>& nodes, const std::vector<Vector3>& place) {
  Vector3 sum{0.0, 0.0, 0.0};
  for (const int node : nodes)
    for (std::size_t c = 0; c < 3; ++c)
      sum[c] += place[node][c] / static_cast<double>(nodes.size());
  return sum;
}

/// Outward normal: away from the middle of the element, independent of the node numbering.
Vector3 outward_normal(const std::vector<int>& face, const std::vector<int>& element,
                       const std::vector<Vector3>& place) {
  Vector3 normal = unit(across(face, place));
  if (dot(normal, minus(middle(face, place), middle(element, place))) < 0.0)
    for (double& component : normal) component = -component;
  return normal;
}

using Column = std::array<std::int64_t, 2>;

/// Identifies the vertical line of a node by its place in plan.
Column column_of(const v1::Frame& frame, int node) {
  constexpr double same_m = 1e-7;
  const int dimension = frame.dimension();
  const auto in_plan = [&](int c) {
    return c + 1 < dimension ? std::llround(frame.node_m(dimension * node + c) / same_m) : 0;
  };
  return {in_plan(0), in_plan(1)};
}

/// The highest node of the solid in each column.
template <class Liquid>
std::map<Column, int> fronts_below_liquid(const v1::Frame& frame, const Liquid& liquid) {
  std::map<Column, int> fronts;
  const int dimension = frame.dimension();
  const auto height = [&](int n) { return frame.node_m(dimension * n + dimension - 1); };
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    if (liquid(n)) continue;
    const auto [front, first] = fronts.emplace(column_of(frame, n), n);
    if (!first && height(n) > height(front->second)) front->second = n;
  }
  return fronts;
}

}  // namespace

double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector3 unit(const Vector3& a) {
  const double length = std::max(std::sqrt(dot(a, a)), 1e-300);
  return {a[0] / length, a[1] / length, a[2] / length};
}

bool is_consistent(const v1::Frame& frame, int dimension) {
  const int nodes = frame.temperature_c_size(), corners = frame.nodes_per_element();
  const int coordinates = dimension * nodes, displacements = frame.displacement_m_size();
  return frame.dimension() == dimension && nodes > 0 && frame.node_m_size() == coordinates &&
         (displacements == 0 || displacements == coordinates) &&
         (corners == 4 || corners == (dimension == 2 ? 3 : 8)) && frame.element_node_size() > 0 &&
         frame.element_node_size() % corners == 0 &&
         std::ranges::all_of(frame.element_node(),
                             [&](int node) { return node >= 0 && node < nodes; });
}

std::vector<double> drawn_displacement(const v1::Frame& frame) {
  if (frame.displacement_m_size() != frame.node_m_size()) return {};
  std::vector<double> drawn(frame.displacement_m().begin(), frame.displacement_m().end());
  const int dimension = frame.dimension(), up = dimension - 1;
  const auto height = [&](int n) { return frame.node_m(dimension * n + up); };
  const double shell = frames::shell_c(frame);
  const auto liquid = [&](int n) { return frame.temperature_c(n) > shell; };
  const auto fronts = fronts_below_liquid(frame, liquid);
  const double level = frame.metal_level_m();
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    if (!liquid(n)) continue;
    double& u = drawn[static_cast<std::size_t>(dimension * n + up)];
    const auto front = fronts.find(column_of(frame, n));
    u = front == fronts.end() || height(front->second) >= level
            ? 0.0
            : frame.displacement_m(dimension * front->second + up) *
                  std::max(0.0, level - height(n)) / (level - height(front->second));
  }
  return drawn;
}

std::vector<Vector3> places_of(const v1::Frame& frame) {
  std::vector<Vector3> place;
  for (int i = 0; i + 2 < frame.node_m_size(); i += 3)
    place.push_back({frame.node_m(i), frame.node_m(i + 1), frame.node_m(i + 2)});
  return place;
}

std::vector<SurfaceFace> surface_of(const v1::Frame& frame) {
  const int corners = frame.nodes_per_element();
  const std::vector<Vector3> place = places_of(frame);
  struct Found {
    int uses = 0, element = 0;
    std::vector<int> face;
  };
  std::map<std::vector<int>, Found> faces;
  for (int e = 0; e < frame.element_node_size() / corners; ++e)
    for (const std::vector<int>& local : faces_of(corners)) {
      std::vector<int> face;
      for (const int i : local) face.push_back(frame.element_node(corners * e + i));
      std::vector<int> key = face;
      std::ranges::sort(key);
      Found& found = faces[key];
      if (found.uses++ == 0) found = {1, e, face};
    }
  std::vector<SurfaceFace> surface;
  for (const auto& [key, found] : faces) {
    if (found.uses != 1) continue;
    const auto first = frame.element_node().begin() + corners * found.element;
    const std::vector<int> element(first, first + corners);
    surface.push_back({found.face, outward_normal(found.face, element, place)});
  }
  return surface;
}

namespace {

using Edge = std::array<int, 2>;

Edge edge_of(int a, int b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Edges that belong to one face only.
std::vector<Edge> boundary_of(const std::vector<std::vector<int>>& faces) {
  std::map<Edge, int> uses;
  for (const auto& face : faces)
    for (std::size_t i = 0; i < face.size(); ++i)
      ++uses[edge_of(face[i], face[(i + 1) % face.size()])];
  std::vector<Edge> boundary;
  for (const auto& [edge, count] : uses)
    if (count == 1) boundary.push_back(edge);
  return boundary;
}

/// Edges between faces that meet at more than 45 degrees in the undeformed slab.
std::vector<Edge> creases_of(const std::vector<SurfaceFace>& surface) {
  constexpr double crease_cosine = 0.7;
  std::map<Edge, std::vector<Vector3>> normals;
  for (const SurfaceFace& face : surface)
    for (std::size_t i = 0; i < face.node.size(); ++i)
      normals[edge_of(face.node[i], face.node[(i + 1) % face.node.size()])].push_back(face.normal);
  std::vector<Edge> creases;
  for (const auto& [edge, beside] : normals)
    if (beside.size() == 2 && dot(beside[0], beside[1]) < crease_cosine) creases.push_back(edge);
  return creases;
}

FrameSkin section_skin(const v1::Frame& frame) {
  FrameSkin skin;
  const auto nodes = frame.element_node().begin();
  for (int i = 0; i < frame.element_node_size(); i += frame.nodes_per_element())
    skin.faces.emplace_back(nodes + i, nodes + i + frame.nodes_per_element());
  skin.edges = boundary_of(skin.faces);
  return skin;
}

FrameSkin slab_skin(const v1::Frame& frame) {
  const auto surface = surface_of(frame);
  const auto place = places_of(frame);
  FrameSkin skin{{}, creases_of(surface)};
  for (const SurfaceFace& face : surface) {
    skin.faces.push_back(face.node);
    if (dot(across(face.node, place), face.normal) < 0.0) std::ranges::reverse(skin.faces.back());
  }
  return skin;
}

}  // namespace

std::optional<FrameSkin> skin_of(const v1::Frame& frame) {
  if (is_consistent(frame, 2)) return section_skin(frame);
  if (is_consistent(frame, 3)) return slab_skin(frame);
  return std::nullopt;
}

}  // namespace dccast::client::render
