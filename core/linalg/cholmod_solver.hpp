#pragma once

#include <memory>
#include <span>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// Dimension of the mesh of the unknowns; it determines ordering and kind of factorisation.
enum class Geometry { plane, solid };

/// Direct solver for symmetric positive definite systems on a fixed pattern, based on CHOLMOD.
///
/// Analyse once per mesh, factorise when the values change, solve as often as needed. Small 2D
/// problems use the simplicial LDL' factorisation with an AMD ordering, larger ones the supernodal
/// one; solids are ordered by METIS on their nodes (measured: the simplicial factorisation is 18 to
/// 46 times slower there). One thread, also in OpenMP: a job has one core.
///
/// Units: those of the caller, as everywhere in this room (sparsity_pattern.hpp).
class CholmodSolver {
public:
  /// Sets up CHOLMOD's workspace. A solver owns its factor: it can be moved but not copied.
  CholmodSolver();
  ~CholmodSolver();
  CholmodSolver(CholmodSolver&&) noexcept;
  CholmodSolver& operator=(CholmodSolver&&) noexcept;

  /// Symbolic analysis. @param pattern  must outlive the solver's use of it
  /// @throws std::bad_alloc when memory is exhausted
  void analyze(const SparsityPattern& pattern, Geometry geometry = Geometry::plane);
  /// Numeric factorisation. @param values  (entry of the pattern)
  /// @return false if the matrix is not positive definite; the factor is then unusable
  [[nodiscard]] bool factorize(std::span<const double> values);
  /// Solves with the last factor. @param x  may be the same storage as `b`
  void solve(std::span<const double> b, std::span<double> x);

  /// Numbers in the factor [1], after analyze().
  double factor_entries() const;
  /// Memory used by the factor [byte], after analyze().
  std::size_t memory_bytes() const;

private:
  /// The structures of CHOLMOD, whose headers stay in the source.
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

}  // namespace dccast::linalg
