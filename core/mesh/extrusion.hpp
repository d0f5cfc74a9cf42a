#pragma once

#include <optional>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// How the nodes of an extruded mesh of hexahedra lie: rows one above the other, all alike,
/// numbered row by row. The nodes at one place of every row form an upright line.
struct Extrusion {
  std::vector<double> height;  ///< (row of nodes) [m], rising
  int lines = 0;               ///< nodes of a row
  std::vector<int> cell;       ///< (cell of a row, 4) its lines

  int rows() const { return static_cast<int>(height.size()); }
};

/// Nothing where the mesh is not one: tetrahedra, or a mesh from a file with other numbers.
std::optional<Extrusion> extrusion_of(const Mesh<3>& mesh);

}  // namespace dccast::mesh
