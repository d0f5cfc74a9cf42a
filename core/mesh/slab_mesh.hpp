#pragma once

#include <optional>
#include <vector>

#include "core/mesh/plan_mesh.hpp"
#include "core/mesh/row_merging.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::mesh {

/// A mesh of rows of cells over a base, graded from the bottom block, which grow upwards. Heat and
/// mechanics of a quarter slab may have plans of their own, over the same rows.
///
/// The top row stretches with the metal level. When it is higher than 1.5 growth cells it is
/// divided: its lower part becomes one growth cell, the rest the new top row. Rows added by growth
/// can be merged in pairs once they are deep below the metal level; nodes and elements above them
/// are then renumbered. While the mould is filled, the top row is divided at the planned heights of
/// the initial rows instead.
template <int Dim>
class SlabMesh {
public:
  /// The built-in mesh. @param spec  section and division; `file` must be empty
  explicit SlabMesh(const SectionSpec& spec);
  /// Over a given base, for heat and mechanics. @param spec  of the rows
  SlabMesh(const SectionSpec& spec, Base<Dim> base);

  /// The present mesh of the mechanics. References to it stay valid; its arrays grow.
  const Mesh<Dim>& mesh() const { return mechanics_.mesh(); }
  const Mesh<Dim>& heat_mesh() const { return heat().mesh(); }
  /// Numbers of cells, rows and nodes of the mechanics' plan.
  int cells_per_row() const { return mechanics_.cells_per_row(); }
  int rows() const { return static_cast<int>(heights_.size()) - 1; }
  int nodes_per_row() const { return mechanics_.nodes_per_row(); }
  int elements_per_row() const { return mechanics_.elements_per_row(); }
  int heat_nodes_per_row() const { return heat().nodes_per_row(); }
  int heat_elements_per_row() const { return heat().elements_per_row(); }
  double level() const { return heights_.back(); }       ///< [m] metal level
  double planned_level() const { return plan_.back(); }  ///< [m] once the mould is filled
  const std::vector<double>& row_heights() const { return heights_; }  ///< [m] of the rows of nodes

  /// Begins with the lowest rows only, before the mould is filled: two, or those that follow the
  /// bowl of the block and one more. @pre nothing has grown yet
  void start_filling();

  /// Raises the metal level.
  /// @param level  [m], not below the present one
  /// @return       heights of the inserted rows of nodes, ascending [m]; empty if the top row was
  ///               only stretched
  std::vector<double> grow_to(double level);

  /// The rows that are deep enough to be merged; may be empty.
  MergedRows rows_to_merge() const;
  /// The same rows of the heat's mesh.
  MergedRows of_heat(MergedRows rows) const;
  /// Merges rows. @param rows  from rows_to_merge()
  void merge(const MergedRows& rows);

  /// Restores the state of a checkpoint. @param row_heights  [m] from `row_heights()`
  void restore(const std::vector<double>& row_heights);

private:
  const PlanMesh<Dim>& heat() const { return heat_ ? *heat_ : mechanics_; }
  void build();
  /// Divides the top row at a height [m] and records the new row of nodes.
  void divide_top_row(double height, std::vector<double>& inserted);

  PlanMesh<Dim> mechanics_;
  std::optional<PlanMesh<Dim>> heat_;  ///< empty if it is the same
  double growth_cell_;                 ///< [m]
  RowMerging merging_;
  std::vector<double> plan_;     ///< [m] heights of the initial rows
  int first_grown_;              ///< row of nodes below the rows added by growth
  std::size_t first_flat_;       ///< row of nodes from which on rows are flat
  std::vector<double> heights_;  ///< [m] of the rows of nodes
};

using SlabMesh2D = SlabMesh<2>;
using SlabMesh3D = SlabMesh<3>;

/// Height of the rows that growth adds [m].
double growth_cell(const SectionSpec& spec);

/// How many rows growth and the division of the topmost row would make of a slab's mesh without
/// merging, when the metal level is at `level` [m]; not a count, since it may be as large as you
/// like.
double unmerged_rows(const SectionSpec& spec, double level);

/// Number of rows of a slab's mesh when the metal level is at `level` [m]. It takes as long as
/// there are unmerged_rows().
int rows_at(const SectionSpec& spec, double level);

}  // namespace dccast::mesh
