#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/linalg/dissection_tree.hpp"
#include "core/linalg/tile_kernels.hpp"

namespace dccast::linalg {

/// Multifrontal Cholesky factorisation (Duff and Reid 1983) of a symmetric positive definite matrix
/// in the order of a nested dissection: each front is dense, and all work is products of 8 x 8
/// numbers.
///
/// Made for 2D meshes that are too large for a band solver: the work of a factorisation grows with
/// the number of unknowns to the power 3/2, not 2. The kernels are chosen at run time for the
/// processor; on one processor the last bits are always the same.
///
/// factorize() and solve() do not allocate memory.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class DissectionCholesky {
public:
  explicit DissectionCholesky(const TileKernels& kernels = best_tile_kernels())
      : kernels_(&kernels) {}

  /// Symbolic analysis.
  void analyze(const SparsityPattern& pattern, const DissectionTree& tree);

  /// @param values  (entry of the pattern)
  /// @return false if the matrix is not positive definite; the factor is then unusable
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Numbers in the factor [1].
  double factor_entries() const;
  /// Memory used by the factor and its structure [byte].
  std::size_t memory_bytes() const;

private:
  /// A front of the tree as the numerical work sees it.
  struct Part {
    int pivots = 0, boundary = 0;       ///< rows of tiles
    int unknowns = 0;                   ///< number of its own unknowns
    int first_row = 0;                  ///< row of its first pivot among all rows of tiles
    std::size_t panel = 0, update = 0;  ///< first tiles
    std::size_t stack = 0;              ///< stack on which its update lies
    std::size_t first_entry = 0;        ///< of the matrix, in `source_` and `target_`
    std::size_t first_node = 0;         ///< of its boundary, in `right_row_` and `in_parent_`
    std::vector<int> children;
  };

  /// Numbers the pivots of all fronts and reserves their panels.
  void place_fronts(const DissectionTree& tree);
  /// Reserves the updates of the fronts on two stacks, one for even and one for odd depths.
  void place_updates(const DissectionTree& tree);
  /// Finds the rows of the boundary of each front.
  void place_boundaries(const DissectionTree& tree);
  /// Finds the rows of a child's boundary in its parent.
  void place_in_parent(const DissectionTree& tree, std::size_t child, std::size_t parent);
  /// Assigns each entry of the matrix to the front that is the first to eliminate one of its
  /// unknowns.
  void place_entries(const SparsityPattern& pattern, const DissectionTree& tree);
  /// The view of a front that the kernels take.
  Front make_front(const Part& part);
  /// Copies the entries of a front to its panel; the diagonal past its last unknown is one.
  void copy_matrix(std::span<const double> values, std::size_t number, const Front& front);
  /// Adds the update of a child to panel and update of its parent (extend-add).
  void add_child(const Part& child, const Front& parent);
  /// add_child() for a fixed number of unknowns per node, so that inner loops are unrolled.
  template <int PerNode>
  void add_columns(const Part& child, const Front& parent);
  /// Nodes on the boundary of a front.
  std::size_t boundary_nodes(std::size_t part) const {
    return part_[part + 1].first_node - part_[part].first_node;
  }
  /// Copies the solution on the boundary of a front to the work array.
  void gather(std::size_t part);
  /// Subtracts the products of the pivots of a front from the right-hand side of its boundary.
  void scatter(std::size_t part);

  const TileKernels* kernels_;
  /// Unknowns per node: 1 for heat, 2 for a section, 3 for a solid.
  int per_node_ = 1;
  std::vector<Part> part_;      ///< in the order of elimination, with an end marker
  std::vector<int> position_;   ///< (unknown) its position among the rows of all pivots
  std::vector<int> right_row_;  ///< (node of a boundary) `position_` of its first unknown
  std::vector<int> in_parent_;  ///< (node of a boundary) row of its first unknown in the parent
  std::vector<int> source_;     ///< entries of the pattern, by front
  std::vector<int> target_;     ///< their indices in the panel of the front
  TileStorage panel_;
  std::array<TileStorage, 2> update_;  ///< of the fronts of even and of odd depth: two stacks
  std::vector<TileRow> inverse_, right_, rest_;
  /// Workspace of backward_front(), zero between calls.
  std::vector<Tile> sums_;
  struct RowOffsets {
    std::vector<int> child, panel, update;
  } offset_;  ///< (node of a boundary) of the rows of a child, in its own update and in its parent
};

}  // namespace dccast::linalg
