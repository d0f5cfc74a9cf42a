#pragma once

#include <optional>

#include "dccast/v1/case.pb.h"

namespace dccast::client {

/// What mesh and time steps of a case leave uncertain of its curl at the end: half the width of the
/// band of docs/error-bars.md [m]. The one place that knows; nothing where no band is known for
/// such a case.
/// @param complete  with all its defaults
/// @param curl_m    computed with it [m]
std::optional<double> discretisation_error(const v1::Case& complete, double curl_m);

}  // namespace dccast::client
