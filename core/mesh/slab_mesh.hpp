#pragma once

#include <vector>

#include "core/mesh/base.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/row_merging.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// The built-in mesh of a section: rows of cells over its base, graded from the bottom block, which
/// grow upwards.
///
/// Nodes are numbered row by row from the bottom, in the order of the base, so that growth only
/// appends: existing nodes and elements keep their numbers, and the connectivity follows from the
/// number of rows alone. Linear elements split each cell: a rectangle along its diagonal from lower
/// left to upper right (the paper's SW-NE), a hexahedron into six tetrahedra around the diagonal
/// from its first corner to the opposite one. Bilinear and trilinear elements use the whole cell.
///
/// The top row stretches with the metal level. When it is higher than 1.5 growth cells it is
/// divided: its lower part becomes one growth cell, the rest the new top row. Rows added by growth
/// can be merged in pairs once they are deep below the metal level; nodes and elements above them
/// are then renumbered. While the mould is filled, the top row is divided at the planned heights of
/// the initial rows instead.
template <int Dim>
class SlabMesh {
public:
  /// @param spec  section and division; `file` must be empty
  explicit SlabMesh(const SectionSpec& spec);

  /// The present mesh. References to it stay valid; its arrays grow.
  const Mesh<Dim>& mesh() const { return mesh_; }
  /// Numbers of cells, rows and nodes of the extruded base.
  int cells_per_row() const { return base_.cells(); }
  int rows() const { return static_cast<int>(heights_.size()) - 1; }
  int nodes_per_row() const { return base_.nodes(); }
  int elements_per_row() const;
  double level() const { return heights_.back(); }       ///< [m] metal level
  double planned_level() const { return plan_.back(); }  ///< [m] once the mould is filled
  const std::vector<double>& row_heights() const { return heights_; }  ///< [m] of the rows of nodes

  /// Begins with the lowest rows only, before the mould is filled. @pre nothing has grown yet
  void start_filling();

  /// Raises the metal level.
  /// @param level  [m], not below the present one
  /// @return       heights of the inserted rows of nodes, ascending [m]; empty if the top row was
  ///               only stretched
  std::vector<double> grow_to(double level);

  /// The rows that are deep enough to be merged; may be empty.
  MergedRows rows_to_merge() const;
  /// Merges rows. @param rows  from rows_to_merge()
  void merge(const MergedRows& rows);

  /// Restores the state of a checkpoint. @param row_heights  [m] from `row_heights()`
  void restore(const std::vector<double>& row_heights);

private:
  /// Makes all nodes and elements from the base and the present heights.
  void build();
  /// Divides the top row at a height [m] and records the new row of nodes.
  void divide_top_row(double height, std::vector<double>& inserted);
  /// Sets the coordinates of the nodes of a row from the base and its height.
  void place_row_of_nodes(int row);
  /// Adds the elements of a row of cells, numbered behind all others.
  void add_row_of_cells(int row);
  /// Adds the facets of the walls along a row of cells.
  void add_walls(int row);
  /// Makes the facets of the lowest row.
  void set_bottom();
  /// Makes the facets of the uppermost row; they change with every growth.
  void set_top();

  /// The plan, and how each of its cells is divided.
  Base<Dim> base_;
  ElementKind kind_;
  double growth_cell_;  ///< [m]
  RowMerging merging_;
  std::vector<double> plan_;     ///< [m] heights of the initial rows
  int first_grown_;              ///< row of nodes below the rows added by growth
  std::vector<double> heights_;  ///< [m] of the rows of nodes
  Mesh<Dim> mesh_;
};

using SlabMesh2D = SlabMesh<2>;
using SlabMesh3D = SlabMesh<3>;

/// Height of the rows that growth adds to the built-in mesh [m].
double growth_cell(const SectionSpec& spec);

/// Number of rows of the built-in mesh when the metal level is at `level` [m].
int rows_at(const SectionSpec& spec, double level);

}  // namespace dccast::mesh
