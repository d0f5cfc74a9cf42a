#pragma once

#include <vector>

namespace dccast::values {

/// A curve at other instants, linear between its own; NaN outside of them.
std::vector<double> at_instants(const std::vector<double>& instants_s,
                                const std::vector<double>& time_s,
                                const std::vector<double>& value);

}  // namespace dccast::values
