#pragma once

#include <cmath>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::linalg::testing {

/// Springs between the neighbours of an n x n grid, of two unknowns a node, coupled at each node.
/// The matrix is singular until something is held.
struct Grid {
  explicit Grid(int n) : side(n) {
    std::vector<int> pair;
    for (int node = 0; node < n * n; ++node) {
      if (node % n + 1 < n) join(pair, node, node + 1);
      if (node / n + 1 < n) join(pair, node, node + n);
    }
    pattern = SparsityPattern(2 * n * n, pair, 4);
    values.assign(pattern.entries(), 0.0);
    for (int e = 0; e < static_cast<int>(pair.size()) / 4; ++e) add(e);
    held.assign(std::size_t(2 * n * n), 0);
    for (int node = 0; node < n; ++node) bottom.push_back(2 * node + 1);
    for (int node = 0; node < n; ++node) held[std::size_t(2 * node * n)] = 1;  // the left side
    for (const int u : bottom) held[std::size_t(u)] = u % 3 != 0;
    for (std::size_t i = 0; i < held.size(); ++i) b.push_back(std::sin(1.0 + 0.7 * double(i)));
  }
  static void join(std::vector<int>& pair, int a, int c) {
    pair.insert(pair.end(), {2 * a, 2 * a + 1, 2 * c, 2 * c + 1});
  }
  void add(int element) {
    constexpr double stiffness[2][2] = {{2.0, 0.5}, {0.5, 1.0}};
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j <= i; ++j) {
        const double sign = i / 2 == j / 2 ? 1.0 : -1.0;
        values[std::size_t(pattern.places(element)[4 * i + j])] +=
            sign * stiffness[i % 2][j % 2] * (1.0 + 0.3 * std::sin(double(element)));
      }
    }
  }

  int side;
  SparsityPattern pattern;
  std::vector<double> values;
  std::vector<int> bottom;
  std::vector<char> held;
  std::vector<double> b;
};

}  // namespace dccast::linalg::testing
