#pragma once

#include <optional>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// Structure of an extruded mesh of hexahedra: identical rows of nodes above each other, numbered
/// row by row. Corresponding nodes of all rows form a vertical line.
struct Extrusion {
  std::vector<double> height;  ///< (row of nodes) [m], ascending
  int lines = 0;               ///< nodes per row
  std::vector<int> cell;       ///< (cell of a row, 4) its lines

  int rows() const { return static_cast<int>(height.size()); }
};

/// The structure of a mesh; empty if the mesh is not extruded: tetrahedra, or a mesh from a file
/// with another numbering.
std::optional<Extrusion> extrusion_of(const Mesh<3>& mesh);

}  // namespace dccast::mesh
