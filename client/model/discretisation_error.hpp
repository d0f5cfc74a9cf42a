#pragma once

#include <optional>

#include "dccast/v1/case.pb.h"

namespace dccast::client {

/// Uncertainty of the final curl caused by mesh and time steps: half the width of the band of
/// docs/error-bars.md [m]. Empty if no band is known for such a case.
/// @param complete  case with all its defaults
/// @param curl_m    computed curl [m]
std::optional<double> discretisation_error(const v1::Case& complete, double curl_m);

}  // namespace dccast::client
