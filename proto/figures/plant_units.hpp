#pragma once

#include <string_view>

#include "dccast/v1/options.pb.h"

namespace dccast::figures {

/// The unit in which a plant reads a quantity, by the table in judgement.proto.
/// @param si  SI unit of a figure, "m", "m/s", "m2/s", "W", "degC", "s"; "1" is a share. A unit
/// that
///            is not in the table stays as it is.
v1::PlantUnit plant_unit(std::string_view si);

}  // namespace dccast::figures
