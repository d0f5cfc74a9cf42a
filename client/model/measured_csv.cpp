#include "client/model/measured_csv.hpp"

#include <optional>

#include "client/model/csv_line.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

constexpr std::size_t most_faults = 10;  // that are reported
constexpr const char* header_form = "\"time [s], curl corner [mm], thermocouple [degC]\"";

std::string monitor_of(std::string name) {
  for (const char* kind : {"curl ", "gap ", "temperature "})
    if (lowered(name).starts_with(kind)) return trimmed(name.substr(std::string(kind).size()));
  return name;
}

/// A column of readings, with the unit of the file.
struct Column {
  std::string unit;
  bool curl = false;
  v1::MeasuredCurve curve;
};

class Reader {
public:
  Reader(const std::string& name, const std::vector<std::string>& monitors)
      : name_(name), monitors_(monitors) {}

  MeasuredFile read(std::istream& stream) {
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
      line_ = number;
      if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
      const bool is_header = columns_.empty() && at_unit_.empty();
      if (is_header)
        read_header(line);
      else
        read_readings(line);
      // Without its header no reading can be judged.
      if ((is_header && !file_.faults.empty()) || file_.faults.size() >= most_faults) break;
    }

    if (at_unit_.empty() && file_.faults.empty())
      fault(1, "is empty; permitted: a header such as " + std::string(header_form));
    // A single reading gives no noise, and a curve none of its shape.
    for (Column& column : columns_) {
      const int count = column.curve.curl_m_size() + column.curve.temperature_c_size();
      if (file_.faults.empty() && count < 2)
        fault(1, column.curve.monitor() + " has " + std::to_string(count) +
                     " readings; permitted: 2 or more");
      file_.curves.push_back(std::move(column.curve));
    }
    return std::move(file_);
  }

private:
  void fault(std::size_t column, const std::string& text) {
    file_.faults.push_back(name_ + ":" + std::to_string(line_) + ":" + std::to_string(column) +
                           ": " + text);
  }

  void read_header(const std::string& line) {
    if (is_utf16(line)) return fault(1, utf16_fault);
    separator_ = separator_of(line);
    const auto cells = cells_of(line, separator_);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto heading = heading_of(cells[i]);
      if (!heading)
        fault(i + 1, "\"" + cells[i] + "\" has no unit; permitted: " + header_form);
      else if (i == 0)
        read_abscissa(*heading);
      else
        read_column(i, *heading);
    }
    if (cells.size() < 2) fault(1, std::string("has one column; permitted: ") + header_form);
  }

  void read_abscissa(const Heading& heading) {
    at_unit_ = heading.unit;
    by_time_ = case_file::convertible(heading.unit, "s");
    if (!by_time_ && !case_file::convertible(heading.unit, "m"))
      fault(1, "[" + heading.unit + "] of \"" + heading.name +
                   "\" is no time and no length; permitted: time [s], cast length [mm]");
  }

  void read_column(std::size_t i, const Heading& heading) {
    Column column{heading.unit, case_file::convertible(heading.unit, "m"), {}};
    if (!column.curl && !case_file::convertible(heading.unit, "degC"))
      fault(i + 1, "[" + heading.unit + "] of \"" + heading.name +
                       "\" is no length and no temperature; permitted: mm, m, in, degC, K");
    const std::string monitor = monitor_of(heading.name);
    std::string known;
    bool found = false;
    for (const std::string& name : monitors_) {
      known += (known.empty() ? "" : ", ") + name;
      found = found || name == monitor;
    }
    if (!found) fault(i + 1, "\"" + monitor + "\" is no monitor of the case; permitted: " + known);
    column.curve.set_monitor(monitor);
    column.curve.set_source(name_);
    columns_.push_back(std::move(column));
  }

  std::optional<double> number(const std::string& cell, const std::string& unit, const char* to,
                               std::size_t column) {
    const auto value = number_in(cell);
    if (!value) {
      fault(column, "\"" + cell + "\" " + fault_of_number(cell) +
                        "; permitted: digits with a point, e.g. 12.5");
      return std::nullopt;
    }
    return case_file::convert(*value, unit, to);
  }

  void read_readings(const std::string& line) {
    const auto cells = cells_of(line, separator_, columns_.size() + 1);
    if (cells.size() != columns_.size() + 1)
      return fault(cells.size(), "has " + std::to_string(cells.size()) + " columns; permitted: " +
                                     std::to_string(columns_.size() + 1) + ", as in the header");

    const auto at = number(cells[0], at_unit_, by_time_ ? "s" : "m", 1);
    if (!at) return;
    if (last_at_ && !(*at > *last_at_))
      fault(1, cells[0] + " does not lie after the reading before; permitted: increasing values");
    last_at_ = at;

    // Gauges may be read at times of their own: an empty cell is no reading.
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (cells[i + 1].empty()) continue;
      Column& column = columns_[i];
      const auto value = number(cells[i + 1], column.unit, column.curl ? "m" : "degC", i + 2);
      if (!value) continue;
      (by_time_ ? column.curve.mutable_time_s() : column.curve.mutable_cast_length_m())->Add(*at);
      (column.curl ? column.curve.mutable_curl_m() : column.curve.mutable_temperature_c())
          ->Add(*value);
    }
  }

  const std::string& name_;
  const std::vector<std::string>& monitors_;
  MeasuredFile file_;
  int line_ = 1;
  char separator_ = ',';
  bool by_time_ = true;
  std::string at_unit_;
  std::optional<double> last_at_;
  std::vector<Column> columns_;
};

}  // namespace

MeasuredFile read_measured(std::istream& stream, const std::string& name,
                           const std::vector<std::string>& monitors) {
  return Reader(name, monitors).read(stream);
}

}  // namespace dccast::client
