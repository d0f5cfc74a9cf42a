#pragma once

#include <span>
#include <vector>

#include "core/linalg/band_cholesky.hpp"
#include "core/linalg/cholmod_solver.hpp"
#include "core/linalg/dissection_cholesky.hpp"

namespace dccast::linalg {

/// Direct solver for symmetric positive definite systems on a fixed pattern: BandCholesky where the
/// band is narrow enough to win, DissectionCholesky in the plane above, CholmodSolver elsewhere.
/// docs/factorisation.md has the measurements.
///
/// Analyse once per mesh, factorise as often as the values change, solve as often as needed.
class DirectSolver {
public:
  /// Symbolic analysis and choice of the method.
  /// @param pattern  must outlive the solver's use of it
  /// @param fronts   sets of unknowns along an edge of the mesh from which an elimination may
  ///                 start; of these orders and the reversed numbering the one of least work is
  ///                 taken. From two of them, neither empty, a dissection in the plane counts its
  ///                 distances
  /// @throws std::bad_alloc when memory is exhausted
  void analyze(const SparsityPattern& pattern, Geometry geometry = Geometry::plane,
               std::span<const std::vector<int>> fronts = {});
  /// Numeric factorisation. @param values  `pattern.entries()` numbers
  /// @return false when the matrix is not positive definite; the factor is then unusable
  bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Share of a factorisation that is repeated if only entries of this unknown change [1].
  double share_to_repeat(int unknown) const {
    return uses_band() ? band_.share_to_repeat(unknown) : 1.0;
  }

  enum class Method { band, dissection, cholmod };
  Method method() const { return method_; }
  bool uses_band() const { return method_ == Method::band; }
  long factorizations() const { return factorizations_; }
  long solves() const { return solves_; }
  /// Numbers in the factor [1], after analyze().
  double factor_entries() const;
  /// What the factor takes [byte], after analyze().
  std::size_t memory_bytes() const;
  /// Threads of CHOLMOD's dense products; the band takes those of the team lent to the thread that
  /// calls. @param threads  at least 1, the default
  void use_threads(int threads) { cholmod_.use_threads(threads); }

private:
  template <class Use>
  auto with_solver(const Use& use) {
    return method_ == Method::band         ? use(band_)
           : method_ == Method::dissection ? use(dissection_)
                                           : use(cholmod_);
  }
  template <class Use>
  auto with_solver(const Use& use) const {
    return method_ == Method::band         ? use(band_)
           : method_ == Method::dissection ? use(dissection_)
                                           : use(cholmod_);
  }

  Method method_ = Method::cholmod;
  BandCholesky band_;
  DissectionCholesky dissection_;
  CholmodSolver cholmod_;
  long factorizations_ = 0;
  long solves_ = 0;
};

/// The measured rule in the plane: whether a band factorisation is faster than one by dissection.
bool band_beats_dissection(const BandShape& shape, int unknowns);

/// The measured rule: whether a band factorisation is faster than CHOLMOD's. In the plane it is
/// asked for one solve a factorisation, of a solid for the twenty of its conjugate gradients.
/// @param shape  of the band, its order being the best known
bool band_wins(const BandShape& shape, int unknowns, Geometry geometry, const TileKernels& kernels);

}  // namespace dccast::linalg
