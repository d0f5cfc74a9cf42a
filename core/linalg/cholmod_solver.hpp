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
/// supernodal one; solids are ordered by METIS (measured: the simplicial factorisation is 18 to 46
/// times slower there). One thread, also of OpenMP: a job has
/// one core.
class CholmodSolver {
public:
  CholmodSolver();
  ~CholmodSolver();
  CholmodSolver(CholmodSolver&&) noexcept;
  CholmodSolver& operator=(CholmodSolver&&) noexcept;

  /// Symbolic analysis. @param pattern  must outlive the solver's use of it
  /// @throws std::bad_alloc when memory is exhausted
  void analyze(const SparsityPattern& pattern, Geometry geometry = Geometry::plane);
  /// Numeric factorisation. @param values  `pattern.entries()` numbers
  /// @return false when the matrix is not positive definite; the factor is then unusable
  bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Numbers in the factor, after analyze().
  double factor_entries() const;

private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

}  // namespace dccast::linalg
