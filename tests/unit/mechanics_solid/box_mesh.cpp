#include "tests/unit/mechanics_solid/box_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace dccast::mechanics::testing {

namespace {

/// Corners of the faces of a cell, seen from outside to the left; the first is on the diagonal of
/// the tetrahedra.
constexpr int corners_of_face[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                       {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
constexpr int tetrahedron[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                   {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};

void add_facets(std::vector<mesh::Facet<3>>& facets, const std::array<int, 8>& corner,
                const int (&of_face)[4], bool triangles) {
  std::array<int, 4> n;
  for (std::size_t i = 0; i < 4; ++i) n[i] = corner[std::size_t(of_face[i])];
  if (triangles) {
    facets.push_back({{n[0], n[1], n[2], 0}, 3, -1});
    facets.push_back({{n[0], n[2], n[3], 0}, 3, -1});
  } else {
    facets.push_back({n, 4, -1});
  }
}

void add_cell(BoxMesh& box, int i, int j, int k, bool tetrahedra) {
  const std::array<int, 8> corner{box.node(i, j, k),
                                  box.node(i + 1, j, k),
                                  box.node(i + 1, j + 1, k),
                                  box.node(i, j + 1, k),
                                  box.node(i, j, k + 1),
                                  box.node(i + 1, j, k + 1),
                                  box.node(i + 1, j + 1, k + 1),
                                  box.node(i, j + 1, k + 1)};
  auto& nodes = box.mesh.element_node;
  if (tetrahedra) {
    for (const auto& t : tetrahedron) {
      for (const int c : t) nodes.push_back(corner[std::size_t(c)]);
    }
  } else {
    nodes.insert(nodes.end(), corner.begin(), corner.end());
  }
  const int at[3] = {i, j, k};
  for (std::size_t f = 0; f < 6; ++f) {
    const std::size_t d = f / 2;
    if (at[d] != (f % 2 == 0 ? 0 : box.cells[d] - 1)) continue;
    add_facets(box.face[f], corner, corners_of_face[f], tetrahedra);
  }
}

}  // namespace

std::vector<int> BoxMesh::nodes_on(Face f) const {
  std::vector<int> nodes;
  for (const auto& facet : facets(f)) {
    for (int i = 0; i < facet.nodes; ++i) nodes.push_back(facet.node[std::size_t(i)]);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

bool BoxMesh::on_boundary(int node) const {
  const int i = node % (cells[0] + 1), j = node / (cells[0] + 1) % (cells[1] + 1),
            k = node / (cells[0] + 1) / (cells[1] + 1);
  return i == 0 || i == cells[0] || j == 0 || j == cells[1] || k == 0 || k == cells[2];
}

BoxMesh box_mesh(std::array<int, 3> cells, bool tetrahedra,
                 const std::function<Vector3(const Vector3&)>& place) {
  BoxMesh box;
  box.cells = cells;
  box.mesh.nodes_per_element = tetrahedra ? 4 : 8;
  for (int k = 0; k <= cells[2]; ++k) {
    for (int j = 0; j <= cells[1]; ++j) {
      for (int i = 0; i <= cells[0]; ++i) {
        const Vector3 x = place({double(i) / cells[0], double(j) / cells[1], double(k) / cells[2]});
        box.mesh.node.insert(box.mesh.node.end(), x.begin(), x.end());
      }
    }
  }
  for (int k = 0; k < cells[2]; ++k) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int i = 0; i < cells[0]; ++i) add_cell(box, i, j, k, tetrahedra);
    }
  }
  return box;
}

BoxMesh distorted_box(const Vector3& size, std::array<int, 3> cells, bool tetrahedra) {
  BoxMesh box = box_mesh(cells, tetrahedra, [&](const Vector3& s) {
    return Vector3{s[0] * size[0], s[1] * size[1], s[2] * size[2]};
  });
  for (int n = 0; n < box.mesh.nodes(); ++n) {
    if (box.on_boundary(n)) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      box.mesh.node[3 * std::size_t(n) + d] +=
          0.25 * size[d] / cells[d] * std::sin(3.0 * n + 2.0 * double(d) + 1.0);
    }
  }
  return box;
}

Vector3 turned(const Vector3& x) {
  const Eigen::AngleAxisd rotation(0.7, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
  const Eigen::Vector3d y = rotation * Eigen::Vector3d(x[0], x[1], x[2]);
  return {y(0), y(1), y(2)};
}

}  // namespace dccast::mechanics::testing
