#pragma once

#include <vector>

namespace dccast::casting {

/// A figure of a step and the place it is taken at [m]; empty where there is none.
struct PlacedFigure {
  double value = 0.0;
  std::vector<double> place{};
};

}  // namespace dccast::casting
