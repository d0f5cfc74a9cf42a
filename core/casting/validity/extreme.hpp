#pragma once

#include <vector>

namespace dccast::casting {

/// The worst value of a field over the slab and where it stands, in the undeformed slab [m].
struct Extreme {
  double value = 0.0;         ///< in the unit of the field
  std::vector<double> place;  ///< coordinates [m]; empty where there is none
};

}  // namespace dccast::casting
