#pragma once

#include <vector>

namespace dccast::casting {

/// The worst value of a field over the slab and its location in the undeformed slab.
struct Extreme {
  double value = 0.0;         ///< [unit of the field]
  std::vector<double> place;  ///< coordinates [m]; empty if there is none
};

}  // namespace dccast::casting
