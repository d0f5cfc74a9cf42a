#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::client::render {

inline constexpr double mm_per_min = 60e3;  ///< in 1 m/s
inline constexpr double litres_per_min_per_m =
    60e3;  ///< in 1 m2/s: litres a minute, per metre of perimeter

/// A number as an engineer writes it: four digits, no zeros behind the last one; "-" for none.
std::string plant_number(double value);

/// A table in the words of the pit: "40 mm/min to 60 s, then to 60 mm/min at 200 s".
/// @param factor  from the stored unit to that of `unit`
std::string curve_in_words(const v1::Curve& curve, double factor, const std::string& unit);

/// A table at a time and a cast length, whichever it stands against, constant outside.
/// @param otherwise  value of a table without points
double curve_value(const v1::Curve& curve, double time_s, double cast_length_m, double otherwise);

/// A case as TOML without digits nobody wrote: speeds in mm/min, numbers to nine digits.
std::string readable_toml(const v1::Case& input);

}  // namespace dccast::client::render
