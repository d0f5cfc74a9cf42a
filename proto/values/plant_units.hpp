#pragma once

#include <string_view>

namespace dccast::values {

/// The unit in which a plant reads a quantity.
struct PlantUnit {
  std::string_view name;  ///< "mm", "mm/min", "kW"; empty for a pure number
  double factor = 1.0;    ///< [plant unit per SI unit]
};

/// @param si  SI unit of a figure, "m", "m/s", "m2/s", "W", "degC", "s"; "1" is a share. A unit
/// that is
///            not in the table stays as it is.
PlantUnit plant_unit(std::string_view si);

}  // namespace dccast::values
