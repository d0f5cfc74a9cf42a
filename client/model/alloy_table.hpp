#pragma once

#include <istream>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"

namespace dccast::client {

/// Puts data that were measured or computed over temperature, as JMatPro exports them, into a card:
/// comma, semicolon or tab between columns, a point in numbers, the temperature in the first
/// column, the keys of a card as names of the others.
///
///     Temperature [C], Liquid [%], Density [g/cm3], Thermal conductivity [W/(m K)]
///
/// What a column replaces goes: a density also the pair of solid and liquid one. With the liquid
/// fraction solidus and liquidus follow the table.
/// @param name  of the file, in faults
/// @return faults with their line; empty: `card` has the data
std::vector<std::string> read_alloy_table(std::istream& stream, const std::string& name,
                                          v1::Alloy& card);

}  // namespace dccast::client
