#pragma once

#include <span>
#include <vector>

#include "core/linalg/band_cholesky.hpp"
#include "core/linalg/cholmod_solver.hpp"

namespace dccast::linalg {

/// Direct solver for symmetric positive definite systems on a fixed pattern: BandCholesky if the
/// band is narrow enough for it to be the fastest, CholmodSolver otherwise.
/// docs/developers/factorisation.md has the measurements.
///
/// Analyse once per mesh, factorise when the values change, solve as often as needed.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class DirectSolver {
public:
  /// Symbolic analysis and choice of the method.
  /// @param pattern  must outlive the solver's use of it
  /// @param fronts   sets of unknowns along an edge of the mesh from which an elimination may
  ///                 start; of these orders and the reversed numbering the one with the least work
  ///                 is used
  /// @throws std::bad_alloc when memory is exhausted
  void analyze(const SparsityPattern& pattern, Geometry geometry = Geometry::plane,
               std::span<const std::vector<int>> fronts = {});
  /// Numeric factorisation. @param values  (entry of the pattern)
  /// @return false if the matrix is not positive definite; the factor is then unusable
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Share of a factorisation that is repeated if only entries of this unknown change [1].
  double share_to_repeat(int unknown) const {
    return uses_band() ? band_.share_to_repeat(unknown) : 1.0;
  }

  /// The factorisation in use, chosen by analyze().
  enum class Method { band, cholmod };
  Method method() const { return method_; }
  bool uses_band() const { return method_ == Method::band; }
  /// Numbers of calls since this object was made, for the figures of a step.
  long factorizations() const { return factorizations_; }
  long solves() const { return solves_; }
  /// Numbers in the factor [1], after analyze().
  double factor_entries() const;
  /// Memory used by the factor [byte], after analyze().
  std::size_t memory_bytes() const;

private:
  /// Calls use(solver) with the solver of the method. @param self  *this, constant or not
  template <class Self, class Use>
  static auto with_solver(Self& self, const Use& use) {
    return self.method_ == Method::band ? use(self.band_) : use(self.cholmod_);
  }

  Method method_ = Method::cholmod;
  BandCholesky band_;
  CholmodSolver cholmod_;
  long factorizations_ = 0;
  long solves_ = 0;
};

}  // namespace dccast::linalg
