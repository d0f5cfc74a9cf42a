#pragma once

#include <vector>

namespace dccast::values {

/// Interpolates a curve linearly at other times; NaN outside its range.
/// @param instants_s  times of the result [s]
/// @param time_s      times of the curve [s]
/// @param value       [any unit]
/// @return            [unit of `value`]
std::vector<double> at_instants(const std::vector<double>& instants_s,
                                const std::vector<double>& time_s,
                                const std::vector<double>& value);

}  // namespace dccast::values
