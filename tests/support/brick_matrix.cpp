#include "tests/support/brick_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::support {

namespace {

constexpr int corners = 8;

/// The end, 0 or 1, of direction d at which corner c of a cell lies.
int corner_end(int c, int d) {
  return c >> d & 1;
}

/// (cell, corner, direction) unknowns of the cells.
std::vector<int> list_cell_unknowns(std::array<int, 2> plan, int rows) {
  std::vector<int> unknown;
  for (int k = 0; k < rows; ++k) {
    for (int j = 0; j < plan[1]; ++j) {
      for (int i = 0; i < plan[0]; ++i) {
        for (int c = 0; c < corners; ++c) {
          const int row = (k + corner_end(c, 2)) * (plan[1] + 1) + j + corner_end(c, 1);
          const int node = row * (plan[0] + 1) + i + corner_end(c, 0);
          for (int d = 0; d < 3; ++d) unknown.push_back(3 * node + d);
        }
      }
    }
  }
  return unknown;
}

/// (corner, direction) derivatives of the shape functions [1/m].
using Gradients = std::array<std::array<double, 3>, corners>;

/// @param point  in the unit cell [1]
/// @param size   of the cell [m]
Gradients gradients(const std::array<double, 3>& point, const std::array<double, 3>& size) {
  Gradients g{};
  for (int c = 0; c < corners; ++c) {
    for (int d = 0; d < 3; ++d) {
      double product = (corner_end(c, d) != 0 ? 1.0 : -1.0) / size[std::size_t(d)];
      for (int o = 0; o < 3; ++o) {
        const double along = point[std::size_t(o)];
        if (o != d) product *= corner_end(c, o) != 0 ? along : 1.0 - along;
      }
      g[std::size_t(c)][std::size_t(d)] = product;
    }
  }
  return g;
}

}  // namespace

BrickMatrix::BrickMatrix(std::array<int, 2> plan, int rows, std::array<double, 3> size)
    : plan_(plan),
      rows_(rows),
      size_(size),
      cell_unknown_(list_cell_unknowns(plan, rows)),
      pattern(3 * (plan[0] + 1) * (plan[1] + 1) * (rows + 1), cell_unknown_, 3 * corners) {}

/// Matrix of a cell for E = 1. Entry (3 a + i, 3 b + j) is the integral of
/// lambda a_,i b_,j + mu (a_,j b_,i + delta_ij grad a . grad b).
std::vector<double> BrickMatrix::cell_stiffness(double poisson) const {
  const double lambda = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  const double mu = 0.5 / (1.0 + poisson);
  const double weight = size_[0] * size_[1] * size_[2] / 8.0;
  const double offset = 0.5 / std::sqrt(3.0);

  std::vector<double> k(24 * 24, 0.0);
  for (int q = 0; q < 8; ++q) {
    std::array<double, 3> point{};
    for (int d = 0; d < 3; ++d)
      point[std::size_t(d)] = 0.5 + (corner_end(q, d) != 0 ? offset : -offset);
    const Gradients g = gradients(point, size_);

    for (std::size_t row = 0; row < 24; ++row) {
      for (std::size_t column = 0; column < 24; ++column) {
        const auto& a = g[row / 3];
        const auto& b = g[column / 3];
        const std::size_t i = row % 3, j = column % 3;
        double entry = lambda * a[i] * b[j] + mu * a[j] * b[i];
        if (i == j) entry += mu * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        k[24 * row + column] += weight * entry;
      }
    }
  }
  return k;
}

void BrickMatrix::add(std::vector<double>& values, int cell, const std::vector<double>& unit,
                      double modulus) const {
  const int* place = pattern.places(cell);
  for (std::size_t row = 0; row < 24; ++row) {
    for (std::size_t column = 0; column <= row; ++column) {
      values[std::size_t(place[24 * row + column])] += modulus * unit[24 * row + column];
    }
  }
}

std::vector<double> BrickMatrix::coordinates() const {
  std::vector<double> x;
  for (int k = 0; k <= rows_; ++k) {
    for (int j = 0; j <= plan_[1]; ++j) {
      for (int i = 0; i <= plan_[0]; ++i) {
        x.insert(x.end(), {i * size_[0], j * size_[1], k * size_[2]});
      }
    }
  }
  return x;
}

std::vector<char> BrickMatrix::supports(int standing) const {
  std::vector<char> held(std::size_t(unknowns()), 0);
  for (int k = 0; k <= rows_; ++k) {
    for (int j = 0; j <= plan_[1]; ++j) held[std::size_t(3 * node(0, j, k))] = 1;
    for (int i = 0; i <= plan_[0]; ++i) held[std::size_t(3 * node(i, 0, k) + 1)] = 1;
  }

  for (int j = 0; j <= std::min(standing, plan_[1]); ++j) {
    for (int i = 0; i <= std::min(standing, plan_[0]); ++i) {
      held[std::size_t(3 * node(i, j, 0) + 2)] = 1;
    }
  }
  return held;
}

void decouple(const linalg::SparsityPattern& pattern, const std::vector<char>& held,
              std::vector<double>& values) {
  const auto& start = pattern.column_start();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    for (std::size_t k = std::size_t(start[c]) + 1; k < std::size_t(start[c + 1]); ++k) {
      if (held[c] != 0 || held[std::size_t(pattern.row()[k])] != 0) values[k] = 0.0;
    }
  }
}

}  // namespace dccast::support
