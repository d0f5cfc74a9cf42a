#pragma once

#include <Eigen/Core>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

/// (point, input) a Latin hypercube as a matrix.
inline Eigen::MatrixXd spread(int points, int inputs, std::uint64_t seed) {
  const auto places = latin_hypercube(points, inputs, seed);
  Eigen::MatrixXd matrix(points, inputs);
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < inputs; ++j)
      matrix(i, j) = places[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return matrix;
}

}  // namespace dccast::statistics
