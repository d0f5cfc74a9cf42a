#pragma once

#include <vector>

namespace dccast::casting {

/// A figure of a step and where it occurs [m]; the place is empty if there is none.
struct PlacedFigure {
  double value = 0.0;           ///< [unit of the figure]
  std::vector<double> place{};  ///< [m]
};

}  // namespace dccast::casting
