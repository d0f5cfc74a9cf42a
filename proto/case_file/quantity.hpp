#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace dccast::case_file {

/// Suffix of the field names of quantities with this unit: "m" -> "_m", "W/(m2 K)" ->
/// "_w_per_m2_k"; "" for "" and "1". Empty for a unit that is not in the table: add it there.
std::optional<std::string_view> unit_suffix(std::string_view unit);

/// A text without blanks and tabs at its ends.
std::string_view trimmed(std::string_view text);

/// A number read from a text with a unit, or the reason why it could not be read.
struct Quantity {
  std::optional<double> value;  ///< in the requested unit
  std::string unit;             ///< as written
  std::string message;          ///< the reason; empty if there is a value
};

/// Reads "60 mm/min" and converts it by UDUNITS-2. Temperatures are converted with their offset.
/// @param text  number, blanks, unit; UTF-8, so "°C" and "µm" are units
/// @param unit  unit of the result in UDUNITS-2 syntax; with "1" the text may have no unit, or "%"
Quantity parse_quantity(std::string_view text, const std::string& unit);

/// Whether a quantity in one unit can be converted to the other.
bool convertible(const std::string& from, const std::string& to);

/// Converts a number [`from`] to [`to`]; empty if the dimensions differ or a unit is unknown.
std::optional<double> convert(double value, const std::string& from, const std::string& to);

/// The shortest text that reads back to the same double [any unit]: "0.1", "4e+12".
std::string number_text(double value);

/// A value [`unit`] with its unit, "0.1 m/s"; without it for units "" and "1".
std::string quantity_text(double value, const std::string& unit);

/// A basic string of TOML, in quotes and with its escapes.
std::string quoted(const std::string& text);

}  // namespace dccast::case_file
