#include "client/model/alloy_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

#include "client/model/csv_line.hpp"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

constexpr const char* liquid_fraction = "liquid_fraction";

/// "Young's modulus" as the key of a card.
std::string key_of(const std::string& name) {
  std::string key;
  for (const char c : lowered(name)) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      key += c;
    else if (c != '\'' && !key.empty() && key.back() != '_')
      key += '_';
  }
  static const std::map<std::string, std::string> other_names{
      {"youngs_modulus", "young_modulus"},
      {"poissons_ratio", "poisson_ratio"},
      {"thermal_conductivity", "conductivity"},
      {"liquid", liquid_fraction},
      {"fraction_liquid", liquid_fraction}};
  const auto found = other_names.find(key);
  return found == other_names.end() ? key : found->second;
}

/// A column as the table of a key; its points by temperature [degC], in units of the file.
struct Column {
  std::string key, unit;
  std::map<double, double> points;
};

/// A path of solidification begins at its last point without liquid and ends at its first without
/// solid.
void trim(Column& path) {
  const double whole = path.unit == "%" ? 100.0 : 1.0;
  auto& points = path.points;
  while (points.size() > 2 && std::next(points.begin())->second <= 0.0)
    points.erase(points.begin());
  while (points.size() > 2 && std::prev(points.end(), 2)->second >= whole)
    points.erase(std::prev(points.end()));
}

/// The columns as a card in TOML.
std::string toml_of(const std::vector<Column>& columns) {
  std::string text;
  for (const Column& column : columns) {
    text += column.key + " = [\n";
    for (const auto& [at, value] : column.points)
      text += column.unit.empty()
                  ? fmt::format("  [\"{} degC\", {}],\n", at, value)
                  : fmt::format("  [\"{} degC\", \"{} {}\"],\n", at, value, column.unit);
    text += "]\n";
    if (column.key == liquid_fraction && !column.points.empty())
      text = fmt::format("solidus = \"{} degC\"\nliquidus = \"{} degC\"\n",
                         column.points.begin()->first, column.points.rbegin()->first) +
             text;
  }
  return text;
}

/// Reads the columns of a table line by line; the first line names them.
class TableReader {
public:
  explicit TableReader(std::string name) : name_(std::move(name)) {}

  void read(std::istream& stream) {
    std::string line;
    for (number_ = 1; std::getline(stream, line) && faults.empty(); ++number_) {
      if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
      if (is_utf16(line)) return fault(utf16_fault);
      if (at_unit_.empty())
        read_headings(line);
      else
        read_row(line);
    }
  }

  std::vector<Column> columns;
  std::vector<std::string> faults;

private:
  void fault(const std::string& text) {
    faults.push_back(fmt::format("{}:{}: {}", name_, number_, text));
  }

  void read_headings(const std::string& line) {
    const auto unit_of = [](const std::string& unit) { return unit == "C" ? "degC" : unit; };
    separator_ = separator_of(line);
    for (const std::string& cell : cells_of(line, separator_)) {
      const Heading heading = heading_of(cell).value_or(Heading{cell, ""});
      if (!at_unit_.empty())
        columns.push_back({key_of(heading.name), unit_of(heading.unit), {}});
      else if (case_file::convertible(unit_of(heading.unit), "degC"))
        at_unit_ = unit_of(heading.unit);
      else
        return fault(fmt::format(
            "\"{}\" is no temperature; permitted in the first column: Temperature [degC]", cell));
    }
  }

  void read_row(const std::string& line) {
    const auto cells = cells_of(line, separator_, columns.size() + 1);
    if (cells.size() > columns.size() + 1)
      fault(fmt::format("has {} cells, and the first line {}", cells.size(), columns.size() + 1));
    for (std::size_t i = 0; i < cells.size() && i <= columns.size(); ++i) {
      if (i > 0 && cells[i].empty()) continue;  // not known there
      const auto value = number_in(cells[i]), at = number_in(cells[0]);
      if (!value)
        fault(fmt::format("\"{}\" {}", cells[i], fault_of_number(cells[i])));
      else if (i > 0 && at)
        columns[i - 1].points[case_file::convert(*at, at_unit_, "degC").value()] = *value;
    }
  }

  const std::string name_;
  int number_ = 0;  ///< of the line
  char separator_ = ',';
  std::string at_unit_;  ///< of the temperature; empty before the first line
};

}  // namespace

std::vector<std::string> read_alloy_table(std::istream& stream, const std::string& name,
                                          v1::Alloy& card) {
  TableReader table(name);
  table.read(stream);
  if (!table.faults.empty()) return table.faults;
  for (Column& column : table.columns)
    if (column.key == liquid_fraction) trim(column);

  v1::Alloy data;
  std::vector<std::string> faults;
  const auto outcome = case_file::read_text(toml_of(table.columns), name, data);
  for (const v1::Fault& each : outcome.faults)
    if (std::ranges::find(outcome.missing_keys, each.field()) == outcome.missing_keys.end())
      faults.push_back(fmt::format("{}: {}", name, case_file::describe(each, {})));
  if (faults.empty()) case_file::replace_data(data, card);
  return faults;
}

}  // namespace dccast::client
