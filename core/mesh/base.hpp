#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// What an extruded mesh stands on: a divided line in 2D, a plan of quadrilaterals in 3D.
template <int Dim>
struct Base {
  static constexpr int nodes_per_cell = Dim == 2 ? 2 : 4;

  /// Where a wall stands on a side of a cell of the base.
  struct Piece {
    int cell = -1;
    /// Of the cell: in 2D its left (0) or right (1) end; in 3D its side from corner k to corner
    /// k + 1.
    int side = 0;
  };
  /// A wall of the slab: the pieces of the rim on which it stands.
  struct Wall {
    std::string name;
    PatchKind kind = PatchKind::side;
    std::array<double, Dim> normal{};  ///< outward unit normal [1]
    std::vector<Piece> pieces;
  };

  std::vector<double> node;    ///< (node, Dim - 1) [m]
  std::vector<int> cell_node;  ///< (cell, nodes_per_cell), in 3D counterclockwise from above
  std::vector<Wall> walls;

  int nodes() const { return static_cast<int>(node.size()) / (Dim - 1); }
  int cells() const { return static_cast<int>(cell_node.size()) / nodes_per_cell; }
};

/// The base of a section's built-in mesh. In 2D from the symmetry plane to the side; of a quarter
/// slab the plan between the planes x = 0 and y = 0, its nodes numbered along y first, which keeps
/// the band of a factorisation narrow.
template <int Dim>
Base<Dim> base_of(const SectionSpec& spec);

template <>
Base<2> base_of<2>(const SectionSpec& spec);
template <>
Base<3> base_of<3>(const SectionSpec& spec);

}  // namespace dccast::mesh
