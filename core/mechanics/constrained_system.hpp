#pragma once

#include <span>
#include <vector>

#include "core/linalg/condensation.hpp"
#include "core/linalg/conjugate_gradients.hpp"
#include "core/mechanics/step_outcome.hpp"

namespace dccast::mechanics {

/// A linear system in which some unknowns are held. The pattern stays as it is: rows and columns of
/// held unknowns are emptied and their diagonal set to a typical stiffness, so that a change of the
/// contact set costs no new analysis.
///
/// In the plane each solution is one by the factor. Of a solid a factorisation costs as much as
/// many solutions: there the factor is kept for as long as it serves as preconditioner of conjugate
/// gradients, through changes of the held unknowns and of the stiffness. Where even one factor is
/// too large the two grids of the workspace take its place: docs/large-solids.md.
class ConstrainedSystem {
public:
  ConstrainedSystem(const linalg::SparsityPattern& pattern, Workspace& work)
      : pattern_(&pattern), work_(&work) {}

  /// Factorises `work.stiffness` with the unknowns marked in `fixed` held.
  /// @param step_of_fixed  what the held unknowns still have to move [m]; its effect on the free
  /// ones
  ///                       is kept for the next solve()
  /// @return false when the reduced matrix is not positive definite
  bool factorize(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// The same stiffness with other unknowns held: by a factorisation of its last rows where those
  /// that changed are eliminated last, else by condensation onto them. After a factorize() that
  /// succeeded, while `work` is not factorised otherwise.
  /// @return false when that does not pay or the matrix is not positive definite: factorise
  bool change(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// A new stiffness in `work.stiffness` that the factor of an older one preconditions.
  /// @return false in the plane, where that does not pay: factorise
  bool renew(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// direction = solution of K d = -residual on the free unknowns, step_of_fixed on the held ones.
  /// Factorises anew where conjugate gradients do not get there.
  /// @param tolerance  [1] of the residual of conjugate gradients, relative
  /// @return false when the matrix is not positive definite, or two grids did not get there
  bool solve(std::span<const char> fixed, std::span<const double> step_of_fixed,
             double tolerance = tight);

  /// Tolerance of a solution that is as good as one by a factor.
  static constexpr double tight = 1e-12;

private:
  bool change_solid(std::span<const char> fixed);
  bool solve_free(std::span<const char> fixed, double tolerance);
  bool solve_by_two_grid(std::span<const char> fixed, double tolerance);
  bool hold_and_factorize(std::span<const char> fixed);
  bool changes_only_last_rows(std::span<const char> fixed) const;
  void lift(std::span<const double> stiffness, std::span<const double> step_of_fixed);

  const linalg::SparsityPattern* pattern_;
  Workspace* work_;
  linalg::Condensation condensation_;
  linalg::ConjugateGradients gradients_;
  std::vector<char> held_;  ///< (unknown) in the factor
  bool lifting_ = false;
  bool factor_is_exact_ = false;  ///< of the present stiffness and held unknowns
  bool renewed_ = false;          ///< the stiffness is no longer that of the factor
};

}  // namespace dccast::mechanics
