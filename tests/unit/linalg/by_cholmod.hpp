#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "core/linalg/cholmod_solver.hpp"

namespace dccast::linalg::testing {

/// The solution that the solvers of this room are held against.
/// @param system  with `pattern`, `values` and right-hand side `b`
template <class System>
std::vector<double> by_cholmod(const System& system) {
  CholmodSolver solver;
  solver.analyze(system.pattern);
  EXPECT_TRUE(solver.factorize(system.values));
  std::vector<double> x(system.b.size());
  solver.solve(system.b, x);
  return x;
}

}  // namespace dccast::linalg::testing
