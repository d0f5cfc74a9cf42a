#pragma once

#include <vector>

namespace dccast::casting {

/// A figure of a step and where it occurs in the undeformed slab.
struct PlacedFigure {
  double value = 0.0;           ///< [unit of the figure]
  std::vector<double> place{};  ///< coordinates [m]; empty if there is none
};

}  // namespace dccast::casting
