#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace dccast::case_file {

/// Suffix of the field names of quantities with this unit: "m" -> "_m", "W/(m2 K)" ->
/// "_w_per_m2_k"; "" for "" and "1". Empty for a unit that is not in the table: add it there.
std::optional<std::string> unit_suffix(std::string_view unit);

}  // namespace dccast::case_file
