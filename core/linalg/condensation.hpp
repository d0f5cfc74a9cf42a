#pragma once

#include <span>
#include <vector>

#include "core/linalg/direct_solver.hpp"

namespace dccast::linalg {

/// Solves with other held unknowns than those a matrix was factorised with, by condensing the
/// system onto the unknowns that changed (paper section 4.3.1 in today's terms).
///
/// With M the matrix of the factor, f its free unknowns, R unknowns released since and H unknowns
/// held since,
///
///     | K_ff  K_fR  E_H | | x_f |   | b_f |
///     | K_Rf  K_RR   0  | | x_R | = | b_R |,
///     | E_H'   0     0  | | l   |   |  0  |
///
/// each change costs one solve with M for its column of W = K_ff^-1 (K_fR, E_H), and the rest is a
/// small quasi-definite matrix. Any kind of factor will do, and nothing of it is changed. It pays
/// as long as the changes are few.
class Condensation {
public:
  /// @param most_changes  above which change() refuses: four solves cost what a factor does, by
  ///                      dissection as by the band
  explicit Condensation(std::size_t most_changes = 4) : most_changes_(most_changes) {}

  /// Starts over. All arguments must outlive the use of this object and stay as they are.
  /// @param values  entries of K, nothing held
  /// @param solver  holds the factor of K with the unknowns `held` decoupled
  /// @param held    (unknown) not zero where the factor holds an unknown
  void start(const SparsityPattern& pattern, std::span<const double> values, DirectSolver& solver,
             std::span<const char> held);

  /// Changes the held unknowns to `held`.
  /// @return false when they are too many, which costs no solve, or when the matrix of the free
  ///         unknowns is not positive definite: factorise
  bool change(std::span<const char> held);

  std::size_t changes() const { return changed_.size(); }

  /// x = K^-1 b on the free unknowns; zero on the held ones, where `b` is not read.
  /// @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

private:
  /// An unknown that is held now and was free in the factor, or the other way round.
  struct Changed {
    int unknown = -1;
    bool released = false;
    std::vector<double> column;  ///< K_fR or E_H of the unknown; K_RR of all released ones in R
    std::vector<double> solved;  ///< K_ff^-1 of it on f, zero elsewhere
  };

  bool few_differ(std::span<const char> held) const;
  Changed condense(int unknown, bool released);
  /// Product of a changed unknown's column with a vector that is zero outside f.
  double along(const Changed& changed, std::span<const double> on_free) const;
  bool factorize_small();
  void solve_small(std::vector<double>& z) const;

  std::size_t most_changes_;
  const SparsityPattern* pattern_ = nullptr;
  std::span<const double> values_;
  DirectSolver* solver_ = nullptr;
  std::vector<char> base_;        ///< (unknown) held in the factor
  std::vector<char> held_;        ///< (unknown) held now
  std::vector<Changed> changed_;  ///< the newly held first: their pivots are the negative ones
  std::vector<double> small_;     ///< (changes, changes) L below the diagonal, D on it
  std::vector<double> right_, unit_;
};

}  // namespace dccast::linalg
