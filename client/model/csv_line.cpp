#include "client/model/csv_line.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dccast::client {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\"");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
}

char separator_of(const std::string& header) {
  for (const char separator : {'\t', ';'})
    if (header.find(separator) != std::string::npos) return separator;
  return ',';
}

std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

std::optional<Heading> heading_of(const std::string& cell) {
  const auto open = cell.find_last_of("[(");
  if (open == std::string::npos || !(cell.ends_with(']') || cell.ends_with(')')))
    return std::nullopt;
  return Heading{trimmed(cell.substr(0, open)),
                 trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

std::optional<double> number_in(const std::string& cell) {
  double value = 0.0;
  const char* const end = cell.data() + cell.size();
  const auto [rest, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace dccast::client
