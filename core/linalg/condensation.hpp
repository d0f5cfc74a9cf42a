#pragma once

#include <span>
#include <vector>

#include "core/linalg/direct_solver.hpp"

namespace dccast::linalg {

/// Solves a system whose set of held unknowns has changed since the factorisation, by condensing it
/// onto the changed unknowns (paper section 4.3.1 in modern terms).
///
/// With M the factorised matrix, f its free unknowns, R the unknowns released since and H the
/// unknowns held since,
///
///     | K_ff  K_fR  E_H | | x_f |   | b_f |
///     | K_Rf  K_RR   0  | | x_R | = | b_R |,
///     | E_H'   0     0  | | l   |   |  0  |
///
/// each change costs one solve with M for its column of W = K_ff^-1 (K_fR, E_H), and a small
/// quasi-definite system remains. Any kind of factor can be used and is not modified. The method
/// pays as long as there are few changes.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class Condensation {
public:
  /// @param most_changes  largest number of changed unknowns that change() accepts: four solves
  ///                      cost as much as a factorisation
  explicit Condensation(std::size_t most_changes = 4) : most_changes_(most_changes) {}

  /// Starts from a new factor. All arguments must outlive the use of this object and must not
  /// change.
  /// @param values  entries of K, nothing held
  /// @param solver  holds the factor of K with the unknowns `held` decoupled
  /// @param held    (unknown) not zero where the factor holds an unknown
  void start(const SparsityPattern& pattern, std::span<const double> values, DirectSolver& solver,
             std::span<const char> held);

  /// Changes the held unknowns to `held`.
  /// @return false if a new factorisation is needed: there are too many changes, which costs no
  ///         solve, or the matrix of the free unknowns is not positive definite
  [[nodiscard]] bool change(std::span<const char> held);

  /// Unknowns whose state differs from that in the factor.
  std::size_t changes() const { return changed_.size(); }

  /// x = K^-1 b on the free unknowns; zero on the held ones, where `b` is not read.
  /// @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

private:
  /// An unknown that is held now but free in the factor, or the other way round.
  struct Changed {
    /// Number of the unknown, and whether the factor held it.
    int unknown = -1;
    bool released = false;
    std::vector<double> column;  ///< column of K_fR or E_H; entries in R: column of K_RR
    std::vector<double> solved;  ///< K_ff^-1 times the column on f, zero elsewhere
  };

  /// Whether the unknowns differ from the factor in at most most_changes_ places.
  bool few_differ(std::span<const char> held) const;
  /// Computes the column of an unknown and solves for it: the one solve that a change costs.
  Changed condense(int unknown, bool released);
  /// Product of a changed unknown's column with a vector that is zero outside f.
  double along(const Changed& changed, std::span<const double> on_free) const;
  /// LDL' of the small matrix, without pivoting: it is quasi-definite (Vanderbei 1995), with
  /// negative pivots for newly held unknowns. @return false if a pivot has the wrong sign
  [[nodiscard]] bool factorize_small();
  /// Solves with the small factor. @param z  right-hand side, then solution
  void solve_small(std::vector<double>& z) const;

  std::size_t most_changes_;
  const SparsityPattern* pattern_ = nullptr;
  std::span<const double> values_;
  DirectSolver* solver_ = nullptr;
  std::vector<char> base_;        ///< (unknown) held in the factor
  std::vector<char> held_;        ///< (unknown) held now
  std::vector<Changed> changed_;  ///< newly held unknowns first: their pivots are negative
  std::vector<double> small_;     ///< (changes, changes) L below the diagonal, D on it
  std::vector<double> right_, unit_;
};

}  // namespace dccast::linalg
