#pragma once

#include <vector>

namespace dccast::casting {

/// A figure of a step and the place it is taken at [m]; empty where there is none.
struct PlacedFigure {
  double value = 0.0;           ///< in the unit of the figure
  std::vector<double> place{};  ///< [m]
};

}  // namespace dccast::casting
