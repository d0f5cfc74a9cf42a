#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// Widths of `cells` cells [m] in a geometric progression, the first of width `first` [m] and with
/// the sum `length` [m].
std::vector<double> graded_cells(double length, int cells, double first);

/// Positions of the ends of cells from zero to `length` [m]; the last one is exactly `length`.
/// @param widths  [m]
/// @param length  [m]
std::vector<double> ends_of_cells(const std::vector<double>& widths, double length);

/// Divides every interval between positions [m] into `refinement` equal ones; returns all positions
/// [m].
std::vector<double> refined(const std::vector<double>& position, int refinement);

/// Division of a cell of an extruded mesh into elements. Corners of a cell: the lower ones in the
/// order of its base, then the upper ones in the same order.
template <int Dim>
struct CellDivision {
  /// Four corners of a quadrilateral, eight of a hexahedron.
  static constexpr int corners = Dim == 2 ? 4 : 8;

  /// A facet of the cell's surface, by corners, and the element of the cell it belongs to.
  struct Part {
    std::vector<int> corner;
    int element = 0;
  };

  std::vector<std::vector<int>> elements;  ///< corners of each
  std::vector<Part> bottom;                ///< outward: down
  std::vector<Part> top;                   ///< outward: up
  std::vector<std::vector<Part>> side;     ///< by side of the base's cell
};

/// The division for a kind of element: undivided, or into triangles or tetrahedra.
template <int Dim>
const CellDivision<Dim>& cell_division(ElementKind kind);

template <>
const CellDivision<2>& cell_division<2>(ElementKind kind);
template <>
const CellDivision<3>& cell_division<3>(ElementKind kind);

/// Structure of an extruded mesh of hexahedra: identical rows of nodes above each other, numbered
/// row by row. Corresponding nodes of all rows form a vertical line.
struct Extrusion {
  std::vector<double> height;  ///< (row of nodes) [m], ascending
  int lines = 0;               ///< nodes per row
  std::vector<int> cell;       ///< (cell of a row, 4) its lines

  /// Rows of nodes; there is one row of cells less.
  int rows() const { return static_cast<int>(height.size()); }
};

/// The structure of a mesh; empty if the mesh is not extruded: tetrahedra, or a mesh from a file
/// with another numbering.
std::optional<Extrusion> extrusion_of(const Mesh<3>& mesh);

}  // namespace dccast::mesh
