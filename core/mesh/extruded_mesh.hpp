#pragma once

#include <vector>

#include "core/mesh/base.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mesh {

/// A mesh of rows of cells over a base, which grows upwards.
///
/// Nodes are numbered row by row from the bottom, in the order of the base, so that growth only
/// appends: an existing node or element keeps its number, and what joins what follows from the
/// number of rows alone. Linear elements split each cell, a
/// rectangle along its diagonal from lower left to upper right (the paper's SW-NE), a hexahedron
/// into six tetrahedra around the diagonal from its first corner to the opposite one; bilinear and
/// trilinear elements take it whole.
///
/// The top row stretches with the metal level. When it is higher than 1.5 growth cells it is
/// divided: its lower part becomes one growth cell, the rest the new top row. Rows that have grown
/// can be merged in pairs once they lie deep; nodes and elements above them get new numbers then.
template <int Dim>
class ExtrudedMesh {
public:
  /// @param row_heights  [m] of the rows of nodes, rising from zero
  /// @param growth_cell  [m] height of a row that is put in
  ExtrudedMesh(Base<Dim> base, ElementKind kind, std::vector<double> row_heights,
               double growth_cell, RowMerging merging = {});

  const Mesh<Dim>& mesh() const { return mesh_; }
  int cells_per_row() const { return base_.cells(); }
  int rows() const { return static_cast<int>(heights_.size()) - 1; }
  int nodes_per_row() const { return base_.nodes(); }
  int elements_per_row() const;
  double level() const { return heights_.back(); }                     ///< [m] metal level
  const std::vector<double>& row_heights() const { return heights_; }  ///< [m] of the rows of nodes

  /// Raises the metal level.
  /// @param level  [m], not below the present one
  /// @return       the heights of the rows of nodes put in between, from below; empty while the top
  ///               row only stretched
  std::vector<double> grow_to(double level);

  /// What there is to merge: rows that have come to lie deep. Empty if nothing.
  MergedRows rows_to_merge() const;
  /// Merges them: @see rows_to_merge()
  void merge(const MergedRows& rows);

  /// Restores the state of a checkpoint. @param row_heights  [m] as `row_heights()` gave them
  void restore(const std::vector<double>& row_heights);

private:
  void build();
  void place_row_of_nodes(int row);
  void add_row_of_cells(int row);
  void add_walls(int row);
  void set_bottom();
  void set_top();

  Base<Dim> base_;
  ElementKind kind_;
  double growth_cell_;  ///< [m]
  RowMerging merging_;
  int first_grown_;              ///< row of nodes below the rows that have grown
  std::vector<double> heights_;  ///< [m] of the rows of nodes
  Mesh<Dim> mesh_;
};

/// Number of rows a mesh of these initial rows has once the metal stands at `level` [m].
int rows_at_level(std::vector<double> row_heights, double growth_cell, const RowMerging& merging,
                  double level);

extern template class ExtrudedMesh<2>;
extern template class ExtrudedMesh<3>;

}  // namespace dccast::mesh
