#pragma once

#include <array>
#include <vector>

#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The shape of a cell, and of the facets between cells: its name, its number in mesh files, and
/// which of its nodes make its edges and facets. An element with other nodes needs a row of
/// cell_shapes(), its interpolation in core/fem/element.hpp, and the division of a cell of the
/// built-in mesh into it (extrusion.cpp).
struct CellShape {
  int dimension;       ///< 1 for a facet of a section
  int nodes;           ///< all of them corners
  int gmsh;            ///< Gmsh's number of it; reference manual, "MSH file format"
  const char* plural;  ///< in messages
  std::vector<std::array<int, 2>> edges;
  /// Corners of each facet. The cell lies to the left of a facet of a section; those of a solid
  /// turn counterclockwise seen from outside.
  std::vector<std::vector<int>> facets;
};

/// The table of shapes.
const std::vector<CellShape>& cell_shapes();

/// The shape with a dimension and a number of nodes. @throws std::logic_error  there is none
const CellShape& cell_shape(int dimension, int nodes);

/// The shape of the cells of an element family.
const CellShape& cell_shape(int dimension, ElementKind element);

/// The shape with a number of Gmsh's; null if there is none.
const CellShape* find_gmsh_shape(int number);

}  // namespace dccast::mesh
