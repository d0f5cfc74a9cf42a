#include "client/html/frame_skin.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "client/html/section_picture.hpp"

namespace dccast::client::render {
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

FrameSkin section_skin(const v1::Frame& frame) {
  FrameSkin skin;
  const int corners = frame.nodes_per_element();
  for (int i = 0; i + corners <= frame.element_node_size(); i += corners)
    skin.faces.emplace_back(frame.element_node().begin() + i,
                            frame.element_node().begin() + i + corners);
  skin.edges = boundary_of(skin.faces);
  return skin;
}

/// Nodes anticlockwise seen from outside.
std::vector<int> turned_outward(const SurfaceFace& face, const std::vector<Vector3>& place) {
  const auto edge = [&](int from, int to) {
    return Vector3{place[to][0] - place[from][0], place[to][1] - place[from][1],
                   place[to][2] - place[from][2]};
  };
  const Vector3 normal =
      cross(edge(face.node[0], face.node[2]), edge(face.node[1], face.node.back()));
  std::vector<int> nodes = face.node;
  if (dot(normal, face.normal) < 0.0) std::ranges::reverse(nodes);
  return nodes;
}

FrameSkin slab_skin(const v1::Frame& frame) {
  FrameSkin skin;
  const auto surface = surface_of(frame);
  const auto place = places_of(frame, 0.0);
  for (const SurfaceFace& face : surface) skin.faces.push_back(turned_outward(face, place));
  skin.edges = creases_of(surface);
  return skin;
}

}  // namespace

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

std::optional<FrameSkin> skin_of(const v1::Frame& frame) {
  if (consistent(frame)) return section_skin(frame);
  if (consistent_3d(frame)) return slab_skin(frame);
  return std::nullopt;
}

}  // namespace dccast::client::render
