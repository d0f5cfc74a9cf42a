#pragma once

#include <span>
#include <vector>

#include "core/linalg/direct_solver.hpp"
#include "core/linalg/line_relaxation.hpp"

namespace dccast::linalg {

/// Two-grid preconditioner of a symmetric positive definite matrix on an extruded mesh of flat
/// cells: line Gauss-Seidel over vertical lines, and a coarse problem on some of the rows, between
/// which the others are interpolated.
///
/// The cells of the coarse grid are about as high as wide. Errors that vary faster than that along
/// the height are removed by the lines, for any horizontal variation; slower ones are
/// represented on the coarse grid, which keeps the full resolution of the plan, so that plates and
/// shells bend in it as they do in the matrix. Symmetric and positive definite: a forward sweep
/// before the coarse problem, a backward sweep after it.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
template <int PerNode>
class TwoGrid {
public:
  /// Chooses the coarse grid and analyses its problem. @param group  [1] height of a coarse row,
  /// relative to the smallest height of a row
  void analyze(const mesh::Extrusion& extruded, double group);

  /// @param pattern  of the mesh, unknowns node by node
  /// @param values   its entries; held unknowns are uncoupled, or have a diagonal that is dominant
  ///                 by orders of magnitude
  /// @param held     (unknown) not zero where held; the coarse problem does not contain these
  /// @return false if the matrix is found not to be positive definite
  [[nodiscard]] bool factorize(const SparsityPattern& pattern, std::span<const double> values,
                               std::span<const char> held);

  /// z = M^-1 r. @param z  not the same storage as `r`
  void apply(std::span<const double> r, std::span<double> z);

  /// Memory used by both grids [byte], after analyze().
  std::size_t memory_bytes() const;

private:
  using Place = typename LineLayout<PerNode>::Place;
  /// A row between two coarse ones.
  struct Between {
    int lower = 0;       ///< coarse row at or below it
    double upper = 0.0;  ///< [1] weight of the coarse row above
  };

  /// Chooses the coarse rows, about `group` times the smallest height of a row apart.
  void choose_rows(const mesh::Extrusion& extruded, double group);
  /// Adds the diagonal block of a node, and the blocks below it in its columns, to both grids.
  void assemble_node(int line, int row, const SparsityPattern& pattern,
                     std::span<const double> values, std::span<const char> held);
  /// Adds a block P' A P to all blocks between the coarse rows on either side of its rows.
  void add_coarse(const Place& place, const double* block);
  /// Adds a block times a weight at one place of the coarse matrix.
  void add_to_coarse(const Place& place, double share, const double* block);
  /// Factorises the coarse matrix. @return false if it is not positive definite
  [[nodiscard]] bool factorize_coarse();
  /// Coarse residual: that of the fine grid times the weights of interpolation, transposed.
  void restrict_residual();
  /// Adds the coarse correction, interpolated linearly between coarse rows.
  void interpolate_correction();

  LineLayout<PerNode> layout_, coarse_layout_;
  LineRelaxation<PerNode> lines_;
  std::vector<Between> between_;  ///< (row)
  SparsityPattern coarse_pattern_;
  DirectSolver coarse_solver_;
  std::vector<double> coarse_own_, coarse_coupling_, coarse_values_;
  std::vector<double> coarse_;  ///< (coarse unknown) residual, then correction
  std::vector<float> right_, solution_, residual_;
};

extern template class TwoGrid<3>;

}  // namespace dccast::linalg
