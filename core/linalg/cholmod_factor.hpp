#pragma once

#include <cholmod.h>

#include <span>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg {

/// CHOLMOD's workspace, one factor and the storage of its solves, freed together. For the sources
/// of this room only.
struct CholmodFactor {
  cholmod_common common{};
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* work_y = nullptr;
  cholmod_dense* work_e = nullptr;
  std::vector<double> masked;  ///< entries of the matrix that is factorised

  explicit CholmodFactor(const SparsityPattern& pattern);
  ~CholmodFactor();
  CholmodFactor(const CholmodFactor&) = delete;

  /// Kind of factor as CholmodSolver chooses it for plane problems of this size.
  void choose_kind();
  /// The matrix of `masked`. @return false when it is not positive definite
  bool factorize();
  /// One of CHOLMOD's partial solves; the result stays in `solution`.
  std::span<double> solve(int system, std::span<const double> b);
};

/// values -> masked with rows and columns of held unknowns emptied but for their diagonal.
void empty_held(const SparsityPattern& pattern, std::span<const double> values,
                std::span<const char> held, std::vector<double>& masked);

}  // namespace dccast::linalg
