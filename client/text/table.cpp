#include "client/text/table.hpp"

#include <algorithm>

#include "client/text/terminal.hpp"

namespace dccast::client {

Table::Table(std::vector<std::string> headings, Rows rows) : rows_(std::move(rows)) {
  for (std::string& heading : headings) {
    right_.push_back(heading.starts_with('>'));
    if (right_.back()) heading.erase(0, 1);
  }
  rows_.insert(rows_.begin(), std::move(headings));
}

std::string Table::text() const {
  std::vector<int> width(right_.size(), 0);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i)
      width[i] = std::max(width[i], display_width(row[i]));
  std::string text;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(static_cast<std::size_t>(width[i] - display_width(row[i])), ' ');
      line += (i == 0 ? "" : "  ") + (right_[i] ? padding + row[i] : row[i] + padding);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string sheet_line(const std::string& name, const std::string& value) {
  constexpr std::size_t width = 14;
  return name + std::string(width - std::min(width, name.size()), ' ') + value + "\n";
}

std::string csv_text(const std::string& text) {
  const bool signed_one = text.find_first_of("+-") == 0;  // "-5 K" is none
  const bool formula = text.find_first_of("=@\t\r") == 0 ||
                       (signed_one && text.find_first_of("=@|!(") != std::string::npos);
  const std::string cell = formula ? "'" + text : text;
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace dccast::client
