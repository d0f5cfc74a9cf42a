#pragma once

#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// The built-in mesh of a rectangular slab section, which grows upwards.
///
/// Cells stand in rows. Nodes are numbered row by row from the bottom, from the symmetry plane to
/// the side, so that growth only appends: an existing node or element keeps its number. P1 splits
/// each cell along its diagonal from lower left to upper right (the paper's SW-NE), Q1 takes it whole.
///
/// The top row stretches with the metal level. When it is higher than 1.5 growth cells it is
/// divided: its lower part becomes one growth cell, the rest the new top row.
class SlabMesh {
public:
  /// @param spec  section and division; `file` must be empty
  explicit SlabMesh(const SectionSpec& spec);

  const Mesh2D& mesh() const { return mesh_; }
  int columns() const { return static_cast<int>(x_.size()) - 1; }  ///< cells in a row
  int rows() const { return static_cast<int>(y_.size()) - 1; }
  int nodes_per_row() const { return static_cast<int>(x_.size()); }
  double level() const { return y_.back(); }                       ///< [m] metal level
  const std::vector<double>& row_heights() const { return y_; }    ///< [m] of the rows of nodes

  /// Raises the metal level.
  /// @param level  [m], not below the present one
  /// @return       the heights of the rows of nodes put in between, from below; empty while the top
  ///               row only stretched
  std::vector<double> grow_to(double level);

  /// Restores the state of a checkpoint. @param row_heights as `row_heights()` gave them
  void restore(const std::vector<double>& row_heights);

private:
  void add_row_of_cells(int row);
  void place_row_of_nodes(int row);
  void rebuild_top();
  void build();

  ElementKind kind_;
  double growth_cell_;     ///< [m]
  std::vector<double> x_;  ///< [m] of the columns of nodes
  std::vector<double> y_;  ///< [m] of the rows of nodes
  Mesh2D mesh_;
};

/// Widths of `cells` cells that sum to `length`, the first of width `first` [m] and each next one
/// larger (or smaller) by the same factor.
std::vector<double> graded_cells(double length, int cells, double first);

/// Number of rows the built-in mesh has when the metal level stands at `level` [m].
int rows_at(const SectionSpec& spec, double level);

}  // namespace dccast::mesh
