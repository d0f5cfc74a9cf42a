#pragma once

#include <array>

namespace dccast::casting {

/// The worst value of a field over the slab and where it stands, in the undeformed slab [m].
struct Extreme {
  double value = 0.0;             ///< in the unit of the field
  std::array<double, 2> place{};  ///< [m]
};

}  // namespace dccast::casting
