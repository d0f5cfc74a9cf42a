#pragma once

#include <span>
#include <vector>

#include "core/linalg/direct_solver.hpp"
#include "core/linalg/line_relaxation.hpp"

namespace dccast::linalg {

/// Preconditioner of a symmetric positive definite matrix on an extruded mesh of flat cells, in two
/// grids: Gauss-Seidel over upright lines, and a coarse problem of some of the rows, between which
/// the others are interpolated along the height.
///
/// The cells of the coarse grid are about as high as wide. What varies faster along the height the
/// lines remove, whatever it does sideways; what varies slowly the coarse grid has, in all the
/// detail of the plan, so that a plate or shell bends in it as it does in the matrix. Symmetric and
/// positive definite: lines in rising order before the coarse problem, in falling order behind it.
template <int PerNode>
class TwoGrid {
public:
  /// Grids and analysis of the coarse problem. @param group  [1] height of a coarse row, in least
  /// heights of a row
  void analyze(const mesh::Extrusion& extruded, double group);

  /// @param pattern  of the mesh, unknowns node by node
  /// @param values   its entries; a held unknown is coupled to no other, or has a diagonal beside
  ///                 which the coupling is nothing
  /// @param held     (unknown) not zero where held; the coarse problem does not know these
  /// @return false when the matrix is found not to be positive definite
  bool factorize(const SparsityPattern& pattern, std::span<const double> values,
                 std::span<const char> held);

  /// z = M^-1 r. @param z  not the same storage as `r`
  void apply(std::span<const double> r, std::span<double> z);

  int coarse_unknowns() const { return coarse_pattern_.unknowns(); }
  /// What both grids take [byte], after analyze().
  std::size_t memory_bytes() const;

private:
  using Place = typename LineLayout<PerNode>::Place;
  /// A row between two coarse ones.
  struct Between {
    int lower = 0;       ///< coarse row at or below it
    double upper = 0.0;  ///< [1] share of the one above
  };

  void choose_rows(const mesh::Extrusion& extruded, double group);
  void take_node(int line, int row, const SparsityPattern& pattern, std::span<const double> values,
                 std::span<const char> held);
  void add_coarse(const Place& at, const double* block);
  void add_to_coarse(const Place& at, double share, const double* block);
  bool factorize_coarse();
  void restrict_residual();
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

extern template class TwoGrid<1>;
extern template class TwoGrid<3>;

}  // namespace dccast::linalg
