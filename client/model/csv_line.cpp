#include "client/model/csv_line.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace dccast::client {

namespace {

/// What may stand around a cell: blanks, quotation marks, no-break spaces, and the byte order mark.
constexpr std::array<std::string_view, 7> blanks{" ",        "\t",           "\r",          "\"",
                                                 "\xC2\xA0", "\xE2\x80\xAF", "\xEF\xBB\xBF"};

}  // namespace

std::string trimmed(const std::string& text) {
  std::string_view left = text;
  const auto begins = [&left](std::string_view blank) { return left.starts_with(blank); };
  const auto ends = [&left](std::string_view blank) { return left.ends_with(blank); };

  auto blank = blanks.begin();
  while ((blank = std::ranges::find_if(blanks, begins)) != blanks.end())
    left.remove_prefix(blank->size());
  while ((blank = std::ranges::find_if(blanks, ends)) != blanks.end())
    left.remove_suffix(blank->size());
  return std::string(left);
}

std::string lowered(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool is_utf16(const std::string& first_line) {
  return first_line.starts_with("\xFF\xFE") || first_line.starts_with("\xFE\xFF") ||
         first_line.find('\0') != std::string::npos;
}

char separator_of(const std::string& header) {
  for (const char separator : {'\t', ';'})
    if (header.find(separator) != std::string::npos) return separator;
  return ',';
}

std::vector<std::string> cells_of(const std::string& line, char separator, std::size_t columns) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  while (cells.size() > columns && cells.back().empty()) cells.pop_back();
  return cells;
}

std::optional<Heading> heading_of(const std::string& cell) {
  if (!cell.ends_with(']') && !cell.ends_with(')')) return std::nullopt;

  // The bracket that the last one closes: a unit may have some of its own, "(W/(m K))".
  const std::string pair = cell.back() == ')' ? "()" : "[]";
  std::size_t open = cell.size() - 1;
  for (int depth = 1; depth > 0 && open > 0;) {
    --open;
    if (cell[open] == pair[1]) ++depth;
    if (cell[open] == pair[0]) --depth;
  }
  if (cell[open] != pair[0]) return std::nullopt;
  return Heading{trimmed(cell.substr(0, open)),
                 trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

std::optional<double> number_in(const std::string& cell) {
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  const bool has_plus = cell.starts_with('+') && !cell.starts_with("+-");
  const auto [rest, error] = std::from_chars(cell.data() + (has_plus ? 1 : 0), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string fault_of_number(const std::string& cell) {
  std::string with_point = cell;
  const auto comma = with_point.find(',');
  if (comma == std::string::npos) return "is no number";
  with_point[comma] = '.';
  return number_in(with_point) ? decimal_comma : "is no number";
}

}  // namespace dccast::client
