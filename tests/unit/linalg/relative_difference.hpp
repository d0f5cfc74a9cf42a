#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace dccast::linalg::testing {

/// Largest difference of two vectors of one size, relative to the largest number of `b`.
inline double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return difference / size;
}

}  // namespace dccast::linalg::testing
