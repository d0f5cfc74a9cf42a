#pragma once

#include <cmath>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg::testing {

/// Unknowns of the square cells of a grid of columns x rows of nodes, numbered row by row, four a
/// cell.
inline std::vector<int> grid_cells(int columns, int rows) {
  std::vector<int> unknown;
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const int sw = row * columns + column;
      unknown.insert(unknown.end(), {sw, sw + 1, sw + columns + 1, sw + columns});
    }
  }
  return unknown;
}
inline std::vector<int> grid_cells(int n) {
  return grid_cells(n, n);
}

/// Sum over the cells of the graph Laplacian of their four corners with a weight by cell, plus
/// `shift` on the diagonal: positive definite for a positive shift.
inline std::vector<double> grid_values(const SparsityPattern& pattern, int n, double shift) {
  std::vector<double> values(pattern.entries(), 0.0);
  for (int e = 0; e < (n - 1) * (n - 1); ++e) {
    const double weight = 1.0 + 0.5 * std::sin(static_cast<double>(e));
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j <= i; ++j) {
        values[std::size_t(pattern.places(e)[4 * i + j])] += i == j ? 3.0 * weight : -weight;
      }
    }
  }
  for (int u = 0; u < n * n; ++u) values[std::size_t(pattern.diagonal(u))] += shift;
  return values;
}

}  // namespace dccast::linalg::testing
