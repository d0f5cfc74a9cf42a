#include "client/text/table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "client/text/terminal.hpp"

namespace dccast::client::render {

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

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  const double step = std::pow(10.0, -decimals);
  // Zero has no sign, also after rounding.
  return fmt::format("{:.{}f}", std::abs(value) < 0.5 * step ? 0.0 : value, std::max(decimals, 0));
}

int mm_decimals(const std::optional<double>& error_m) {
  constexpr int hundredths = 2;  // no curl is known better
  if (!error_m || !std::isfinite(*error_m) || *error_m <= 0.0) return hundredths;

  const double error_mm = 1e3 * *error_m;
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(error_mm)));
  // 0.996 is rounded to 1.0, which has one decimal less.
  const bool carries = std::round(error_mm * std::pow(10.0, decimals)) >= 99.5;
  return std::clamp(carries ? decimals - 1 : decimals, 0, hundredths);
}

std::string mm_errors(double lower_m, double upper_m, int decimals) {
  if (lower_m == upper_m) return "± " + mm(upper_m, decimals);
  // An error that rounds to nothing reads as none: "-0 +0.01".
  const double least_m = 0.5e-3 * std::pow(10.0, -decimals);
  const auto side = [&](double error_m) { return error_m < least_m ? "0" : mm(error_m, decimals); };
  return fmt::format("-{} +{}", side(lower_m), side(upper_m));
}

std::string mm(double metres, int decimals) {
  return fixed(1e3 * metres, decimals);
}

}  // namespace dccast::client::render
