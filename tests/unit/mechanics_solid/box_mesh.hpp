#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mechanics::testing {

using Vector3 = std::array<double, 3>;

enum class Face { x_low, x_high, y_low, y_high, z_low, z_high };

/// A box of cells x, y, z, each a hexahedron or six tetrahedra, with the facets of its faces.
struct BoxMesh {
  mesh::Mesh<3> mesh;
  std::array<std::vector<mesh::Facet<3>>, 6> face;
  std::array<int, 3> cells;

  const std::vector<mesh::Facet<3>>& facets(Face f) const { return face[std::size_t(f)]; }
  int node(int i, int j, int k) const { return (k * (cells[1] + 1) + j) * (cells[0] + 1) + i; }
  std::vector<int> nodes_on(Face f) const;
  bool on_boundary(int node) const;
};

/// @param place  where the node of share (x, y, z) of the box stands, each from 0 to 1
BoxMesh box_mesh(std::array<int, 3> cells, bool tetrahedra,
                 const std::function<Vector3(const Vector3&)>& place);

/// A box from the origin whose inner nodes are moved by up to a quarter of a cell.
BoxMesh distorted_box(const Vector3& size, std::array<int, 3> cells, bool tetrahedra);

/// Turned by 0.7 about one oblique axis.
Vector3 turned(const Vector3& x);

}  // namespace dccast::mechanics::testing
