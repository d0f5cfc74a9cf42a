#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// Division of a cell of an extruded mesh into elements. Corners of a cell: the lower ones in the
/// order of its base, then the upper ones in the same order.
template <int Dim>
struct CellDivision {
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
const CellDivision<Dim>& division_of(ElementKind kind);

template <>
const CellDivision<2>& division_of<2>(ElementKind kind);
template <>
const CellDivision<3>& division_of<3>(ElementKind kind);

}  // namespace dccast::mesh
