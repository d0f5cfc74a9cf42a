#pragma once

#include <memory>
#include <span>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// How the unknowns lie in space: it decides ordering and kind of factorisation.
enum class Geometry { plane, solid };

/// Direct solver for symmetric positive definite systems on a fixed pattern, over CHOLMOD.
///
/// Analyse once per mesh, factorise as often as the values change, solve as often as needed.
/// Small plane problems use the simplicial LDL' factorisation with an AMD ordering, larger ones the
/// supernodal one; solids are ordered by METIS on their nodes (measured: the simplicial
/// factorisation is 18 to 46 times slower there). One thread, also of OpenMP, unless more are asked
/// for: a job has one core.
class CholmodSolver {
public:
  CholmodSolver();
  ~CholmodSolver();
  CholmodSolver(CholmodSolver&&) noexcept;
  CholmodSolver& operator=(CholmodSolver&&) noexcept;

  /// Threads of the dense products inside a factorisation. @param threads  at least 1, the default
  void use_threads(int threads) { threads_ = threads; }

  /// Symbolic analysis. @param pattern  must outlive the solver's use of it
  /// @throws std::bad_alloc when memory is exhausted
  void analyze(const SparsityPattern& pattern, Geometry geometry = Geometry::plane);
  /// Numeric factorisation. @param values  `pattern.entries()` numbers
  /// @return false when the matrix is not positive definite; the factor is then unusable
  bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Numbers in the factor [1], after analyze().
  double factor_entries() const;
  /// What the factor takes [byte], after analyze().
  std::size_t memory_bytes() const;

private:
  struct Storage;
  int threads_ = 1;
  std::unique_ptr<Storage> storage_;
};

}  // namespace dccast::linalg
