#include "tests/unit/mechanics/box_mesh.hpp"

#include <algorithm>
#include <vector>

namespace dccast::mechanics::testing {

namespace {

using Corners = std::array<int, 8>;

/// Corners of the faces of a cell, seen from outside to the left; the first is on the diagonal of
/// the tetrahedra.
constexpr int corners_of_face[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                       {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
constexpr int tetrahedron[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                   {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
/// Corners of a cell as steps along x, y and z.
constexpr int step_to_corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

void add_facets(std::vector<mesh::Facet<3>>& facets, const Corners& corner, const int (&of_face)[4],
                bool triangles) {
  std::array<int, 4> n;
  for (std::size_t i = 0; i < 4; ++i) n[i] = corner[std::size_t(of_face[i])];
  if (triangles) {
    facets.push_back({{n[0], n[1], n[2], 0}, 3, -1});
    facets.push_back({{n[0], n[2], n[3], 0}, 3, -1});
  } else {
    facets.push_back({n, 4, -1});
  }
}

void add_cell(mesh::Mesh3D& box, const std::array<int, 3>& cells, const std::array<int, 3>& at,
              bool tetrahedra) {
  Corners corner;
  for (std::size_t c = 0; c < 8; ++c) {
    const auto& step = step_to_corner[c];
    corner[c] =
        ((at[2] + step[2]) * (cells[1] + 1) + at[1] + step[1]) * (cells[0] + 1) + at[0] + step[0];
  }

  if (tetrahedra) {
    for (const auto& t : tetrahedron) {
      for (const int c : t) box.element_node.push_back(corner[std::size_t(c)]);
    }
  } else {
    box.element_node.insert(box.element_node.end(), corner.begin(), corner.end());
  }

  for (std::size_t f = 0; f < 6; ++f) {
    const std::size_t d = f / 2;
    if (at[d] != (f % 2 == 0 ? 0 : cells[d] - 1)) continue;
    add_facets(box.patches[f].facets, corner, corners_of_face[f], tetrahedra);
  }
}

/// The element to which a facet of the boundary belongs.
int owner(const mesh::Mesh3D& box, const mesh::Facet<3>& facet) {
  for (int e = 0; e < box.elements(); ++e) {
    const int *first = box.nodes_of(e), *end = first + box.nodes_per_element;
    const bool owns = std::all_of(facet.node.begin(), facet.node.begin() + facet.nodes,
                                  [&](int n) { return std::find(first, end, n) != end; });
    if (owns) return e;
  }
  return -1;
}

}  // namespace

mesh::Mesh3D box_mesh(const std::array<int, 3>& cells, bool tetrahedra,
                      const std::function<Vector3(const Vector3&)>& place) {
  using mesh::PatchKind;
  mesh::Mesh3D box;
  box.nodes_per_element = tetrahedra ? 4 : 8;
  box.patches = {
      {"x_low", PatchKind::symmetry, {-1, 0, 0}, {}}, {"x_high", PatchKind::side, {1, 0, 0}, {}},
      {"y_low", PatchKind::symmetry, {0, -1, 0}, {}}, {"y_high", PatchKind::side, {0, 1, 0}, {}},
      {"z_low", PatchKind::bottom, {0, 0, -1}, {}},   {"z_high", PatchKind::top, {0, 0, 1}, {}}};

  for (int k = 0; k <= cells[2]; ++k) {
    for (int j = 0; j <= cells[1]; ++j) {
      for (int i = 0; i <= cells[0]; ++i) {
        const Vector3 x = place({double(i) / cells[0], double(j) / cells[1], double(k) / cells[2]});
        box.node.insert(box.node.end(), x.begin(), x.end());
      }
    }
  }
  for (int k = 0; k < cells[2]; ++k) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int i = 0; i < cells[0]; ++i) add_cell(box, cells, {i, j, k}, tetrahedra);
    }
  }
  for (auto& patch : box.patches)
    for (auto& facet : patch.facets) facet.element = owner(box, facet);
  return box;
}

}  // namespace dccast::mechanics::testing
