#pragma once

#include <span>

#include "core/mesh/base.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The mesh over a plan: rows of cells over its base.
///
/// Nodes are numbered row by row from the bottom, in the order of the base, so that growth only
/// appends: existing nodes and elements keep their numbers, and the connectivity follows from the
/// number of rows alone. Linear elements split each cell: a rectangle along its diagonal from lower
/// left to upper right (the paper's SW-NE), a hexahedron into six tetrahedra around the diagonal
/// from its first corner to the opposite one. Bilinear and trilinear elements use the whole cell.
///
/// Over a block with a bowl the height of a row is that over the lip; it sinks over the bowl by the
/// block's depth, fully at the bottom and not at all from a given height on.
template <int Dim>
class PlanMesh {
public:
  /// @param flat_from  [m] height from which on the rows are flat; below it they follow the block
  PlanMesh(Base<Dim> base, ElementKind kind, double flat_from);

  const Mesh<Dim>& mesh() const { return mesh_; }
  int cells_per_row() const { return base_.cells(); }
  int nodes_per_row() const { return base_.nodes(); }
  int elements_per_row() const;

  /// Builds all rows. @param heights  [m] of the rows of nodes
  void build(std::span<const double> heights);
  /// Follows a raised metal level: stretches the top row of cells and adds those above it.
  /// @param heights  [m] of the rows of nodes
  void raise(std::span<const double> heights);

private:
  int rows() const { return mesh_.nodes() / base_.nodes() - 1; }
  void place_row_of_nodes(int row, double height);  ///< height [m]
  void add_row_of_cells(int row);
  void add_walls(int row);
  void set_bottom();
  void set_top();

  Base<Dim> base_;
  ElementKind kind_;
  double flat_from_;  ///< [m]
  Mesh<Dim> mesh_;
};

}  // namespace dccast::mesh
