#include "client/session/readings_csv.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "client/model/csv_line.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {

namespace {

/// Longest time between two readings in which a lever is taken as known (follow.proto) [s].
constexpr double longest_gap_s = 10.0;

const std::string curl = "curl ";  // before the monitor of a gauge

constexpr const char* header_form =
    "\"time [s], speed [mm/min], water [l/min/m], narrow water [l/min/m], metal [degC], curl corner "
    "[mm]\"";

}  // namespace

/// What a column may be.
struct ReadingsTable::Quantity {
  std::vector<std::string> names;
  std::string unit;  ///< of the message
  void (v1::Reading::*set)(double);
};

const std::vector<ReadingsTable::Quantity>& ReadingsTable::quantities() {
  static const std::vector<Quantity> all{
      {{"time"}, "s", &v1::Reading::set_time_s},
      {{"speed", "casting speed"}, "m/s", &v1::Reading::set_casting_speed_m_per_s},
      {{"metal", "casting temperature"}, "degC", &v1::Reading::set_casting_temperature_c},
      {{"water"}, "m2/s", &v1::Reading::set_water_flow_m2_per_s},
      {{"narrow water"}, "m2/s", &v1::Reading::set_narrow_water_flow_m2_per_s}};
  return all;
}

const ReadingsTable::Quantity* ReadingsTable::quantity_of(const std::string& name) {
  const auto found = std::ranges::find_if(quantities(), [&](const Quantity& each) {
    return std::ranges::find(each.names, name) != each.names.end();
  });
  return found == quantities().end() ? nullptr : &*found;
}

ReadingsTable::Line ReadingsTable::take(const std::string& text) {
  Line line;
  ++number_;
  if (trimmed(text).empty() || trimmed(text).starts_with('#')) return line;

  if (separator_ != 0) {
    read_cells(cells_of(text, separator_), line);
  } else {
    separator_ = separator_of(text);
    read_header(cells_of(text, separator_), line);
  }
  return line;
}

void ReadingsTable::read_header(const std::vector<std::string>& cells, Line& line) {
  std::vector<std::string> left_out;
  cells_ = cells.size();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto heading = heading_of(cells[i]);
    const Quantity* const quantity = heading ? quantity_of(heading->name) : nullptr;
    const bool is_curl = heading && heading->name.starts_with(curl);
    if (!quantity && !is_curl) {
      left_out.push_back(fmt::format("\"{}\"", cells[i]));
      continue;
    }

    const std::string& unit = quantity ? quantity->unit : "m";
    if (!case_file::convertible(heading->unit, unit))
      throw CommandFailed(ExitCode::invalid,
                          fmt::format("readings, line {}: [{}] of \"{}\" cannot be converted to {}",
                                      number_, heading->unit, heading->name, unit));
    columns_.push_back({i, heading->name, heading->unit, quantity, {}});
    if (!is_curl) continue;
    gauges_.push_back(trimmed(heading->name.substr(curl.size())));
    columns_.back().monitor = gauges_.back();
  }

  const auto is_time = [](const Column& each) { return each.quantity == &quantities().front(); };
  if (!std::ranges::any_of(columns_, is_time) || std::ranges::all_of(columns_, is_time))
    throw CommandFailed(ExitCode::invalid,
                        fmt::format("readings, line {}: a column for the time and one for a lever "
                                    "or a curl are needed; permitted: {}",
                                    number_, header_form));
  if (!left_out.empty())
    line.remarks.push_back(
        fmt::format("columns that are left out: {}", fmt::join(left_out, ", ")));
}

void ReadingsTable::read_cells(const std::vector<std::string>& cells, Line& line) {
  const auto remark = [&](const std::string& text) {
    line.remarks.push_back(fmt::format("line {}: {}", number_, text));
  };
  if (cells.size() != cells_)
    return remark(fmt::format("left out: it has {} columns, the header {}", cells.size(), cells_));

  v1::Reading reading;
  bool has_time = false;
  for (const Column& column : columns_) {
    const std::string& cell = cells[column.cell];
    if (cell.empty()) continue;
    const auto number = number_in(cell);
    if (!number) {
      remark(fmt::format("\"{}\" of {} is no number and left out", cell, column.name));
      continue;
    }
    if (!column.quantity) {
      v1::MeasuredCurl& measured = *reading.add_curls();
      measured.set_monitor(column.monitor);
      measured.set_curl_m(case_file::convert(*number, column.unit, "m").value());
      continue;
    }
    (reading.*column.quantity->set)(
        case_file::convert(*number, column.unit, column.quantity->unit).value());
    has_time = has_time || column.quantity == &quantities().front();
  }

  if (!has_time) return remark("left out: it has no time");
  if (last_s_ && reading.time_s() <= *last_s_)
    return remark(fmt::format("left out: {:g} s is not later than {:g} s", reading.time_s(),
                              *last_s_));
  if (last_s_ && reading.time_s() - *last_s_ > longest_gap_s)
    remark(fmt::format("no reading for {:g} s: the plan of the case holds there",
                       reading.time_s() - *last_s_));
  last_s_ = reading.time_s();
  line.reading = std::move(reading);
}

}  // namespace dccast::client
