#pragma once

#include <span>
#include <vector>

#include "core/linalg/condensation.hpp"
#include "core/linalg/conjugate_gradients.hpp"
#include "core/mechanics/solve_step.hpp"

namespace dccast::mechanics {

/// A linear system in which some unknowns are held at given values. The pattern does not change:
/// rows and columns of held unknowns are zeroed and their diagonal is set to a typical stiffness,
/// so that a change of the contact set needs no new symbolic analysis.
///
/// In 2D every solution uses the factor directly. In 3D a factorisation costs as much as many
/// solutions: the factor is kept as preconditioner of conjugate gradients as long as it is good
/// enough, through changes of the held unknowns and of the stiffness. If even one factor is too
/// large, the two-grid preconditioner of the workspace replaces it:
/// docs/developers/factorisation.md.
class ConstrainedSystem {
public:
  ConstrainedSystem(const linalg::SparsityPattern& pattern, Workspace& work)
      : pattern_(&pattern), work_(&work) {}

  /// Factorises `work.stiffness` with the unknowns marked in `fixed` held.
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]; its effect
  ///                       on the free ones is kept for the next solve()
  /// @return false if the reduced matrix is not positive definite
  [[nodiscard]] bool factorize(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// Same stiffness, other held unknowns: refactorises only the last rows if the changed unknowns
  /// are eliminated last, else condenses the system onto them. @pre factorize() has succeeded and
  /// the factor in `work` is unchanged since
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]
  /// @return false if a new factorisation is needed: this one would not pay, or the matrix is not
  ///         positive definite
  [[nodiscard]] bool change(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// Accepts a new stiffness in `work.stiffness`, with the factor of an older one as
  /// preconditioner.
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]
  /// @return false in 2D, where this does not pay: a new factorisation is needed
  [[nodiscard]] bool renew(std::span<const char> fixed, std::span<const double> step_of_fixed);

  /// Updates the kept factor by the last iteration, which has moved the free unknowns along
  /// `work.direction` and changed `work.last_residual` to `work.residual`. The updates end with the
  /// next change of held unknowns or stiffness. @see linalg::SecantUpdates
  /// @param length  share of the direction that was taken [1]
  void learn(std::span<const char> fixed, double length);

  /// Solves K d = -residual on the free unknowns, with d = step_of_fixed on the held ones, and
  /// stores d in `work.direction`. Refactorises if conjugate gradients do not converge.
  /// @param step_of_fixed  displacement that the held unknowns still have to make [m]
  /// @param tolerance      [1] relative residual of conjugate gradients
  /// @return false if the matrix is not positive definite, or the two-grid solver did not converge
  [[nodiscard]] bool solve(std::span<const char> fixed, std::span<const double> step_of_fixed,
                           double tolerance = tight);

  /// Tolerance of a solution as accurate as a direct one [1].
  static constexpr double tight = 1e-12;

private:
  /// change() in 3D, where the old factor becomes a preconditioner.
  [[nodiscard]] bool change_solid(std::span<const char> fixed);
  /// @param tolerance  [1] relative residual
  [[nodiscard]] bool solve_free(std::span<const char> fixed, double tolerance);
  /// Zeroes rows and columns of the unknowns in `fixed` [not zero: held] and factorises.
  /// @return false if the matrix is not positive definite
  [[nodiscard]] bool hold_and_factorize(std::span<const char> fixed);
  /// Whether all unknowns that differ from those held in the factor are eliminated last.
  bool changes_only_last_rows(std::span<const char> fixed) const;
  // `stiffness` [force/m], `step_of_fixed` [m].
  void lift(std::span<const double> stiffness, std::span<const double> step_of_fixed);

  const linalg::SparsityPattern* pattern_;
  Workspace* work_;
  linalg::Condensation condensation_;
  linalg::ConjugateGradients gradients_;
  std::vector<char> held_;  ///< (unknown) not zero where held in the factor
  bool lifting_ = false;
  bool factor_is_exact_ = false;  ///< the factor is that of the present stiffness and held unknowns
  bool renewed_ = false;          ///< the stiffness has changed since the factorisation
};

}  // namespace dccast::mechanics
