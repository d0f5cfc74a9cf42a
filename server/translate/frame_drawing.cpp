// What of a stored frame is drawn: its surface or section, the outline, and where liquid stands.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/cell_shape.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {
namespace {

using Face = std::vector<int>;  ///< its nodes, in order around it
using Edge = std::array<int, 2>;

/// The elements of a frame, each as a face.
std::vector<Face> elements_of(const v1::Frame& frame) {
  std::vector<Face> elements;
  const auto nodes = frame.element_node().begin();
  for (int i = 0; i < frame.element_node_size(); i += frame.nodes_per_element())
    elements.emplace_back(nodes + i, nodes + i + frame.nodes_per_element());
  return elements;
}

/// The faces of a slab that belong to one element only, counterclockwise seen from outside.
std::vector<Face> surface_of(const v1::Frame& frame) {
  struct Found {
    int uses = 0;
    Face face;
  };
  const auto& facets = mesh::cell_shape(frame.dimension(), frame.nodes_per_element()).facets;
  std::map<Face, Found> faces;  // by their nodes in ascending order
  for (const Face& element : elements_of(frame))
    for (const std::vector<int>& corners : facets) {
      Face face;
      for (const int corner : corners) face.push_back(element[std::size_t(corner)]);

      Face key = face;
      std::ranges::sort(key);
      Found& found = faces[key];
      ++found.uses;
      found.face = std::move(face);
    }

  std::vector<Face> surface;
  for (auto& [key, found] : faces)
    if (found.uses == 1) surface.push_back(std::move(found.face));
  return surface;
}

/// The faces beside each edge, by their places in the list.
std::map<Edge, std::vector<std::size_t>> faces_by_edge(const std::vector<Face>& faces) {
  std::map<Edge, std::vector<std::size_t>> beside;
  for (std::size_t number = 0; number < faces.size(); ++number) {
    const Face& face = faces[number];
    for (std::size_t i = 0; i < face.size(); ++i) {
      const auto [first, last] = std::minmax(face[i], face[(i + 1) % face.size()]);
      beside[{first, last}].push_back(number);
    }
  }
  return beside;
}

/// Outward unit normal of a face of the undeformed slab.
Eigen::Vector3d normal_of(const v1::Frame& frame, const Face& face) {
  const auto place = [&](int node) {
    return Eigen::Vector3d(frame.node_m(3 * node), frame.node_m(3 * node + 1),
                           frame.node_m(3 * node + 2));
  };
  // Of the diagonals, or of two sides of a triangle.
  const Eigen::Vector3d first = place(face[2]) - place(face[0]);
  const Eigen::Vector3d second = place(face.back()) - place(face[1]);
  return first.cross(second).normalized();
}

/// Whether an edge is drawn: one at the rim of a section, or one where two faces of a slab meet at
/// more than 45 degrees.
bool is_sharp(const v1::Frame& frame, const std::vector<Face>& faces,
              const std::vector<std::size_t>& beside) {
  constexpr double crease_cosine = 0.7;
  if (frame.dimension() == 2) return beside.size() == 1;
  return beside.size() == 2 &&
         normal_of(frame, faces[beside[0]]).dot(normal_of(frame, faces[beside[1]])) < crease_cosine;
}

void add_skin(v1::Frame& frame) {
  const std::vector<Face> faces = frame.dimension() == 2 ? elements_of(frame) : surface_of(frame);
  for (const Face& face : faces)
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      for (const int node : {face[0], face[i], face[i + 1]}) frame.add_skin_triangle(node);

  for (const auto& [edge, beside] : faces_by_edge(faces))
    if (is_sharp(frame, faces, beside))
      for (const int node : edge) frame.add_skin_edge(node);
}

/// Identifies the vertical line of a node by its place in plan.
using Column = std::array<std::int64_t, 2>;

Column column_of(const v1::Frame& frame, int node) {
  constexpr double same_m = 1e-7;
  const int dimension = frame.dimension();
  const auto in_plan = [&](int c) {
    return c + 1 < dimension ? std::llround(frame.node_m(dimension * node + c) / same_m) : 0;
  };
  return {in_plan(0), in_plan(1)};
}

/// Gives liquid the displacement that it is drawn with: above the front the vertical one falls
/// linearly from that of the front to zero at the metal level; liquid with no node of the solid
/// straight below it is drawn where it is poured.
void level_liquid(v1::Frame& frame) {
  if (frame.displacement_m().empty()) return;

  const int dimension = frame.dimension(), up = dimension - 1;
  const auto height = [&](int n) { return frame.node_m(dimension * n + up); };
  const double shell_c = frame.shell_c();
  const auto is_liquid = [&](int n) { return frame.temperature_c(n) > shell_c; };

  // The highest node of the solid in each column.
  std::map<Column, int> fronts;
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    if (is_liquid(n)) continue;
    const auto [front, is_first] = fronts.emplace(column_of(frame, n), n);
    if (!is_first && height(n) > height(front->second)) front->second = n;
  }

  const double level = frame.metal_level_m();
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    if (!is_liquid(n)) continue;
    double drawn_m = 0.0;
    if (const auto front = fronts.find(column_of(frame, n));
        front != fronts.end() && height(front->second) < level)
      drawn_m = frame.displacement_m(dimension * front->second + up) *
                std::max(0.0, level - height(n)) / (level - height(front->second));
    frame.set_displacement_m(dimension * n + up, drawn_m);
  }
}

}  // namespace

void make_drawing(v1::Frame& frame) {
  add_skin(frame);
  level_liquid(frame);
}

}  // namespace dccast::translate
