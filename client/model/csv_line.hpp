#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::client {

/// A text without blanks and quotation marks around it.
std::string trimmed(const std::string& text);

/// The separator of a table whose header this is: tab, semicolon or comma, in this order.
char separator_of(const std::string& header);

/// The cells of a line, trimmed.
std::vector<std::string> cells_of(const std::string& line, char separator);

/// A column's name and unit.
struct Heading {
  std::string name, unit;
};

/// "curl corner [mm]" as name and unit, also in round brackets; empty: it has no unit.
std::optional<Heading> heading_of(const std::string& cell);

/// A cell with a point for decimals as a number; empty: it is none, or not finite.
std::optional<double> number_in(const std::string& cell);

}  // namespace dccast::client
