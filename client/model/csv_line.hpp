#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace dccast::client {

/// A text without blanks and quotation marks around it. No-break spaces and the mark of UTF-8 at
/// the begin of a file are blanks, too.
std::string trimmed(const std::string& text);

/// A text in small letters, those of ASCII.
std::string lowered(std::string text);

/// Whether the first line of a table is UTF-16, as some programs of Windows write it.
bool is_utf16(const std::string& first_line);
/// The fault of such a table, with the remedy.
inline constexpr const char* utf16_fault =
    "the text is UTF-16; permitted: UTF-8, in PowerShell Out-File -Encoding utf8";

/// The separator of a table whose header this is: tab, semicolon or comma, in this order.
char separator_of(const std::string& header);

/// The cells of a line, trimmed.
/// @param columns  of the header; empty cells beyond them, of a separator at the end, are dropped
std::vector<std::string> cells_of(const std::string& line, char separator, std::size_t columns = 1);

/// A column's name and unit.
struct Heading {
  std::string name, unit;
};

/// "curl corner [mm]" as name and unit, also in round brackets; empty: it has no unit.
std::optional<Heading> heading_of(const std::string& cell);

/// A cell with a point for decimals as a number; empty: it is none, or not finite.
std::optional<double> number_in(const std::string& cell);

/// Why a cell is no number: this, or "is no number".
inline constexpr const char* decimal_comma = "has a decimal comma";
std::string fault_of_number(const std::string& cell);

}  // namespace dccast::client
