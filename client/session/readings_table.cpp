#include "client/session/readings_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "client/model/csv_line.hpp"
#include "client/model/json.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {

namespace {

/// Longest time between two readings in which a lever is taken as known (follow.proto) [s].
constexpr double longest_gap_s = 10.0;
/// A cast length that has not risen yet for so long tells that the block stands, whatever the steps
/// of its counter [s].
constexpr double longest_step_of_counter_s = 10.0;
/// A sensor that shows exactly the same for so long may be dead [s].
constexpr double longest_repetition_s = 120.0;
/// A bottom block that is slower stands: 1 mm/min, above the noise of a drive [m/s].
constexpr double still_m_per_s = 1e-3 / 60.0;
/// No block is faster; the server leaves out what is (case.proto) [m/s].
constexpr double fastest_m_per_s = 0.1;
/// A length that rises so fast at first does so by a step of its counter: 150 mm/min [m/s].
constexpr double swift_m_per_s = 150e-3 / 60.0;
/// The zero of a sensor drifts: down to -5 mm/min the block stands [m/s].
constexpr double drift_m_per_s = 5e-3 / 60.0;
/// Readings that are kept while the block stands: an hour at one a second.
constexpr std::size_t most_waiting = 3600;

/// Names that are remembered, so that a source of endless new ones does not fill the memory.
constexpr std::size_t most_names = 1000;

constexpr const char* header_form =
    "\"time [s], speed [mm/min], water [l/min/m], narrow water [l/min/m], metal [degC], curl "
    "corner "
    "[mm]\", or a JSON object with such names";

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string quoted_list(const std::vector<std::string>& names) {
  std::vector<std::string> quoted;
  for (const std::string& name : names)
    quoted.push_back(fmt::format("\"{}\"", values::shown(name)));
  return fmt::format("{}", fmt::join(quoted, ", "));
}

/// Whether a block can have such a speed, or stands with a sensor that drifts.
bool is_speed(double m_per_s) {
  return m_per_s >= -drift_m_per_s && m_per_s <= fastest_m_per_s;
}

/// Sets a value of a reading [unit of the message], but time and cast length.
void set_value(const Column& column, double value, v1::Reading& reading) {
  switch (column.measured) {
    case Measured::casting_speed:
      return reading.set_casting_speed_m_per_s(value);
    case Measured::casting_temperature:
      return reading.set_casting_temperature_c(value);
    case Measured::water_flow:
      return reading.set_water_flow_m2_per_s(value);
    case Measured::narrow_water_flow:
      return reading.set_narrow_water_flow_m2_per_s(value);
    case Measured::second_water_flow:
      return reading.set_second_water_flow_m2_per_s(value);
    case Measured::water_temperature:
      return reading.set_water_temperature_c(value);
    case Measured::metal_level:
      return reading.set_metal_level_m(value);
    case Measured::curl: {
      v1::MeasuredCurl& measured = *reading.add_curls();
      measured.set_monitor(column.monitor);
      return measured.set_curl_m(value);
    }
    // Both place the reading; they are no value of it.
    case Measured::time:
    case Measured::cast_length:
      return;
  }
}

/// A number in the unit of the message, or a time stamp in seconds since 1970; empty: it is
/// neither.
std::optional<double> value_in(const std::string& cell, const Column& column) {
  if (column.unit.empty()) return seconds_of_stamp(cell);
  const auto number = number_in(cell);
  if (!number) return std::nullopt;
  const double value = converted(*number, column);
  const double most = column.measured == Measured::time ? longest_time_s : infinity;
  return std::abs(value) < most ? std::optional(value) : std::nullopt;
}

}  // namespace

ReadingsTable::ReadingsTable(std::optional<ColumnMap> map, SourceClock clock)
    : map_(std::move(map)), clock_(std::move(clock)) {
  if (!map_) return;
  columns_ = map_->columns;
  zero_s_ = map_->zero.at_motion ? std::nullopt : std::optional(map_->zero.at_s);
}

std::string ReadingsTable::at_line(const std::string& text) const {
  return fmt::format("line {}: {}", number_, text);
}

void ReadingsTable::remark_first(const std::string& kind, const std::string& text, Line& line) {
  if (++faulty_[kind] == 1) line.remarks.push_back(at_line(text));
}

void ReadingsTable::refuse(const std::string& kind, const std::string& text, Line& line) {
  remark_first(kind, text, line);
  if (line.fault.empty()) line.fault = at_line(text);
}

/// Remarks the first cell of a column that cannot be read, and counts all of them.
void ReadingsTable::refuse_cell(std::size_t column, const std::string& cell, Line& line) {
  const Column& of = columns_[column];
  const std::string fault =
      of.unit.empty() ? "is no time stamp such as 2026-11-27T04:00:12Z" : fault_of_number(cell);
  const std::string text =
      fmt::format("\"{}\" of {} {} and left out{}", values::shown(cell), values::shown(of.name),
                  fault, fault == decimal_comma ? ": numbers have a point" : "");
  if (++unreadable_[column] == 1) line.remarks.push_back(at_line(text));
  if (line.fault.empty()) line.fault = at_line(text);
}

std::vector<std::string> ReadingsTable::summary() const {
  std::vector<std::string> counts;
  for (std::size_t i = 0; i < unreadable_.size(); ++i)
    if (unreadable_[i] > 1)
      counts.push_back(fmt::format("{}: {} cells could not be read and were left out",
                                   values::shown(columns_[i].name), unreadable_[i]));
  for (const auto& [kind, count] : faulty_)
    if (count > 1) counts.push_back(fmt::format("{}: {} in all", kind, count));
  return counts;
}

/// A time on the clock of the source, as it shows it.
std::string ReadingsTable::clock_text(double seconds) const {
  const auto time = std::ranges::find(columns_, Measured::time, &Column::measured);
  return time->unit.empty() ? stamp_of_seconds(seconds) : case_file::quantity_text(seconds, "s");
}

std::vector<std::string> ReadingsTable::gauges() const {
  std::vector<std::string> monitors;
  for (const Column& column : columns_)
    if (column.measured == Measured::curl) monitors.push_back(column.monitor);
  return monitors;
}

ReadingsTable::Line ReadingsTable::take(const std::string& text, std::optional<double> arrival_s) {
  Line line;
  ++number_;
  arrival_s_ = arrival_s;
  if (text.size() > longest_line) {
    refuse("lines that are too long", fmt::format("left out: longer than {} bytes", longest_line),
           line);
    return line;
  }
  if (!has_header() && is_utf16(text))
    throw invalid(fmt::format("readings, line {}: {}", number_, utf16_fault));

  const std::string body = trimmed(text);
  if (body.empty() || body.starts_with('#')) return line;
  // The first line decides between rows and JSON objects; see take_object().
  if (body.starts_with('{'))
    take_object(body, line);
  else
    take_row(text, line);
  return line;
}

void ReadingsTable::take_row(const std::string& text, Line& line) {
  if (!has_header()) {
    separator_ = separator_of(text);
    return read_header(cells_of(text, separator_), line);
  }
  if (separator_ == 0)
    return refuse("lines that are no JSON object",
                  "left out: it is no JSON object, as the lines before are", line);

  const auto row = cells_of(text, separator_, header_.size());
  if (take_header_again(row)) return;
  if (row.size() != header_.size()) {
    const bool may_be_decimals = separator_ == ',' && row.size() > header_.size();
    return refuse(
        "lines with another number of columns",
        fmt::format("left out: it has {} columns, the header {}{}", row.size(), header_.size(),
                    may_be_decimals ? "; numbers have a point, not a decimal comma" : ""),
        line);
  }

  std::vector<std::string> cells;
  for (const Column& column : columns_) {
    const auto place = std::ranges::find(header_, column.name) - header_.begin();
    cells.push_back(row[static_cast<std::size_t>(place)]);
  }
  read_cells(cells, line);
}

bool ReadingsTable::take_header_again(const std::vector<std::string>& row) {
  if (row == header_) return true;
  const auto has = [&](const Column& column) { return std::ranges::count(row, column.name) > 0; };
  const auto time = std::ranges::find(columns_, Measured::time, &Column::measured);
  if (!has(*time)) return false;

  // The order of the columns may be another one.
  for (const Column& column : columns_)
    if (!has(column))
      throw invalid(
          fmt::format("readings, line {}: this header has no \"{}\", as the first one "
                      "had; give both files the same columns",
                      number_, values::shown(column.name)));
  header_ = row;
  return true;
}

void ReadingsTable::take_object(const std::string& text, Line& line) {
  const auto [members, twice] = members_of_object(text);
  if (!members)
    return refuse("lines that are no complete JSON object",
                  "left out: it is no complete JSON object", line);
  if (!twice.empty())
    return refuse("objects with a name twice",
                  fmt::format("left out: \"{}\" is there twice; give each value a name of its own",
                              values::shown(twice)),
                  line);
  if (has_header() && separator_ != 0)
    return refuse("JSON objects among rows",
                  "left out: it is a JSON object, the lines before are rows", line);
  if (members->empty()) return refuse("lines without a time", "left out: it has no time", line);

  std::vector<std::string> names;
  for (const auto& [name, member] : *members) names.push_back(name);
  if (has_header())
    report_new_names(names, line);
  else
    read_header(std::move(names), line);

  // A member that is missing is an empty cell: the last value holds.
  std::vector<std::string> cells;
  for (const Column& column : columns_) {
    const auto member = members->find(column.name);
    cells.push_back(member == members->end() ? std::string() : trimmed(member->second));
  }
  read_cells(cells, line);
}

void ReadingsTable::read_header(std::vector<std::string> names, Line& line) {
  header_ = std::move(names);
  if (map_)
    find_columns_of_map(line);
  else
    read_columns_of_header();
  // A sensor that is dead repeats itself; see report_repetition().
  repetitions_.resize(columns_.size());
  unreadable_.resize(columns_.size());

  std::vector<std::string> left_out;
  for (const std::string& name : header_)
    if (std::ranges::find(columns_, name, &Column::name) == columns_.end())
      left_out.push_back(name);
  if (!left_out.empty())
    line.remarks.push_back("columns that are left out: " + quoted_list(left_out));
}

/// Reports names that the first object lacks, each once. The columns stay those of the first
/// object, as the job has its gauges from there.
void ReadingsTable::report_new_names(const std::vector<std::string>& names, Line& line) {
  for (const std::string& name : names) {
    if (header_.size() >= most_names) return;
    if (std::ranges::find(header_, name) != header_.end()) continue;
    header_.push_back(name);
    if (std::ranges::find(columns_, name, &Column::name) != columns_.end()) continue;
    line.remarks.push_back(at_line(fmt::format(
        "\"{}\" is left out: the first object does not have it; there null stands for no "
        "value",
        values::shown(name))));
  }
}

void ReadingsTable::read_columns_of_header() {
  try {
    for (const std::string& name : header_)
      if (auto column = column_of_heading(name)) columns_.push_back(std::move(*column));
  } catch (const CommandFailed& failure) {
    throw invalid(fmt::format("readings, line {}: {}", number_, failure.what()));
  }

  if (const std::string fault = fault_among(columns_); !fault.empty())
    throw invalid(fmt::format("readings, line {}: {}; permitted: {}. Other names: --columns FILE",
                              number_, fault, header_form));
}

void ReadingsTable::find_columns_of_map(Line& line) {
  std::vector<std::string> missing;
  for (const Column& column : columns_) {
    const auto count = std::ranges::count(header_, column.name);
    if (count > 1)
      throw invalid(
          fmt::format("readings, line {}: \"{}\" is there twice; give each column a name of "
                      "its own",
                      number_, values::shown(column.name)));
    if (count == 0) missing.push_back(column.name);
  }
  if (missing.empty()) return;

  // An object may hold some of the values only.
  const std::string text =
      fmt::format("there is no {} among {}", quoted_list(missing), quoted_list(header_));
  if (separator_ == 0) {
    line.remarks.push_back(at_line(text));
    return;
  }
  throw invalid(
      fmt::format("readings, line {}: {}; name one of these in the file of columns, or "
                  "leave the column out of it",
                  number_, text));
}

void ReadingsTable::read_cells(const std::vector<std::string>& cells, Line& line) {
  std::vector<std::optional<double>> measured(columns_.size());
  std::optional<double> length_m;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (cells[i].empty()) continue;
    measured[i] = value_in(cells[i], columns_[i]);
    if (!measured[i]) {
      refuse_cell(i, cells[i], line);
      continue;
    }
    if (columns_[i].measured == Measured::time)
      line.time_s = measured[i];
    else
      line.has_values = true;
    if (columns_[i].measured == Measured::cast_length) length_m = measured[i];
  }
  if (!line.time_s) return refuse("lines without a time", "left out: it has no time", line);
  // Speed from length, and repetitions, need readings in their order.
  if (!follows_last(cells, line)) return;

  v1::Reading reading;
  reading.set_time_s(*line.time_s);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!measured[i] || columns_[i].measured == Measured::time) continue;
    set_value(columns_[i], *measured[i], reading);
    report_repetition(i, *measured[i], *line.time_s, line);
  }
  if (length_m)
    set_speed(*line.time_s, *length_m, reading, line);
  else
    keep_speed(*line.time_s);
  place_in_time(std::move(reading), line);
}

bool ReadingsTable::follows_last(const std::vector<std::string>& cells, Line& line) {
  const auto text = [this](double seconds) {
    return zero_s_ ? fmt::format("{:g} s", seconds - *zero_s_) : clock_text(seconds);
  };
  const std::size_t content = std::hash<std::string>{}(fmt::format("{}", fmt::join(cells, "\n")));
  const SourceClock::Placed placed = clock_.place(*line.time_s, arrival_s_, content);
  if (placed.is_earlier) {
    refuse("lines that are not later than the one before",
           fmt::format("left out: {} is not later than {}", text(placed.time_s), text(*last_s_)),
           line);
    return false;
  }

  line.time_s = placed.time_s;
  if (placed.is_jump)
    remark_first("jumps of the clock", "the clock of the source " + placed.remark, line);
  // The last values hold for this long and no longer.
  if (const double pause_s = last_s_ ? placed.time_s - *last_s_ : 0.0; pause_s > longest_gap_s) {
    std::string gap =
        fmt::format("no reading for {:g} s: the plan of the case holds there", pause_s);
    if (!placed.is_jump && !placed.remark.empty()) gap += "; " + placed.remark;
    remark_first("gaps without a reading", gap, line);
  }
  before_s_ = last_s_;
  last_s_ = placed.time_s;
  return true;
}

/// Whether no block moves from the last length to this one. Of two that agree with each other the
/// second is taken: the counter was set anew.
bool ReadingsTable::is_odd(double time_s, double length_m, Line& line) {
  const auto rate_since = [&](const std::pair<double, double>& before) {
    return (length_m - before.second) / (time_s - before.first);
  };
  if (is_speed(rate_since(*last_length_))) {
    odd_length_.reset();
    return false;
  }

  const auto odd = std::exchange(odd_length_, std::pair(time_s, length_m));
  if (odd && is_speed(rate_since(*odd))) {
    last_length_ = odd;
    rise_s_ = odd->first;
    odd_length_.reset();
    course_.reset();
    return false;
  }
  remark_first("cast lengths that fall or jump",
               fmt::format("the cast length {} from {:g} to {:g} mm; the speed is left out",
                           length_m < last_length_->second ? "falls" : "jumps",
                           1e3 * last_length_->second, 1e3 * length_m),
               line);
  return true;
}

void ReadingsTable::keep_speed(double time_s) {
  if (!course_) return;
  // After that the server follows the plan, which is not known here.
  if (time_s - course_->measured_s > longest_gap_s) return course_.reset();
  course_->length_m += course_->speed_m_per_s * (time_s - course_->time_s);
  course_->time_s = time_s;
}

void ReadingsTable::hold_speed(double time_s, double speed_m_per_s, Line& line) {
  const auto send = [&](double at_s) {
    v1::Reading reading;
    reading.set_time_s(at_s);
    reading.set_casting_speed_m_per_s(speed_m_per_s);
    place_in_time(std::move(reading), line);
  };
  // Between two readings the server interpolates: without one right behind the last, half of each
  // change of the speed would be lost.
  constexpr double right_after_s = 1e-3;
  if (!before_s_ || *before_s_ + 2.0 * right_after_s > time_s) return;
  const bool is_known = course_ && course_->speed_m_per_s == speed_m_per_s;
  if (!is_known) send(*before_s_ + right_after_s);

  // A length tells its mean speed over a gap, too, unless the source was away for long.
  constexpr double apart_s = 0.9 * longest_gap_s, longest_filled_s = 3600.0;
  if (time_s - *before_s_ > longest_filled_s) return;
  for (double at_s = *before_s_ + apart_s; at_s < time_s - right_after_s; at_s += apart_s)
    send(at_s);
}

/// The speed with which the server meets this length. The first length gives none.
void ReadingsTable::set_speed(double time_s, double length_m, v1::Reading& reading, Line& line) {
  if (!last_length_) {
    last_length_ = {time_s, length_m};
    first_length_s_ = rise_s_ = due_s_ = time_s;
    return keep_speed(time_s);
  }
  if (is_odd(time_s, length_m, line)) return keep_speed(time_s);

  // A length that trembles adds up to its highest values: what was cast stays cast.
  const auto last = *last_length_;
  last_length_ = {time_s, std::max(length_m, last.second)};
  const bool rises = length_m > last.second, is_first_rise = rises && !length_rises_;
  length_rises_ = length_rises_ || rises;
  // Before its first rise a coarse counter stays although the block may move.
  if (!length_rises_ && time_s - first_length_s_ < longest_step_of_counter_s)
    return keep_speed(time_s);

  // The step of a coarse counter belongs to the time since its last one, and is spread over as
  // much.
  const double begin_s = before_s_.value_or(last.first);
  if (rises) {
    const bool is_coarse = length_m - last.second > swift_m_per_s * (time_s - last.first);
    const double of_first_s = is_coarse ? longest_step_of_counter_s : 0.0;
    const double between_rises_s = is_first_rise ? of_first_s : last.first - rise_s_;
    due_s_ = time_s + std::min(between_rises_s, longest_step_of_counter_s);
    rise_s_ = time_s;
  }
  const bool is_known = course_ && course_->time_s == begin_s;
  const double known_m = is_known ? course_->length_m : last.second;
  const double since_s = is_known ? begin_s : last.first;
  const double speed =
      std::clamp((last_length_->second - known_m) / (std::max(due_s_, time_s) - since_s), 0.0,
                 fastest_m_per_s);
  hold_speed(time_s, speed, line);
  course_ = Course{.time_s = time_s,
                   .length_m = known_m + speed * (time_s - since_s),
                   .speed_m_per_s = speed,
                   .measured_s = time_s};
  reading.set_casting_speed_m_per_s(speed);
}

/// Reports a value that is exactly the same for long since the block moves.
void ReadingsTable::report_repetition(std::size_t column, double value, double time_s, Line& line) {
  // A sensor at rest before the block moves may well repeat its value.
  if (!zero_s_ || time_s < *zero_s_) return;
  auto& repetition = repetitions_[column];
  if (!repetition || repetition->value != value) {
    repetition = Repetition{.value = value, .since_s = time_s};
    return;
  }
  if (repetition->reported || time_s - repetition->since_s < longest_repetition_s) return;

  repetition->reported = true;
  line.remarks.push_back(at_line(
      fmt::format("{} has not changed at all for {:g} s; it counts, but look whether its sensor is "
                  "alive",
                  values::shown(columns_[column].name), time_s - repetition->since_s)));
}

/// Gives a reading the time of the case; while that is unknown it waits.
void ReadingsTable::place_in_time(v1::Reading reading, Line& line) {
  const double time_s = reading.time_s();
  // A sensor that is broken tells neither that the block moves nor that it stands.
  const bool knows_speed =
      reading.has_casting_speed_m_per_s() && is_speed(reading.casting_speed_m_per_s());
  const bool moves = knows_speed && reading.casting_speed_m_per_s() > still_m_per_s;
  if (!zero_s_ && moves) find_zero(time_s, line);
  if (!zero_s_ && knows_speed) still_s_ = time_s;

  waiting_.push_back({std::move(reading), number_});
  if (waiting_.size() > most_waiting) leave_out_oldest(line);
  if (!zero_s_) return;

  // The block moves: what was measured during the hold gets its negative times now.
  for (ReadingOfLine& each : waiting_) {
    each.reading.set_time_s(each.reading.time_s() - *zero_s_);
    line.readings.push_back(std::move(each));
  }
  waiting_.clear();
}

void ReadingsTable::leave_out_oldest(Line& line) {
  waiting_.pop_front();
  if (std::exchange(leaves_out_oldest_, true)) return;
  line.remarks.push_back(at_line(
      fmt::format("the block has not moved for {} readings; older ones are left out from now on",
                  most_waiting)));
}

/// The block moves: it started when it was last seen to stand.
void ReadingsTable::find_zero(double time_s, Line& line) {
  if (!still_s_)
    throw invalid(
        fmt::format("readings, line {1}: the bottom block moves already at {0}, so its start "
                    "is not known; give it in the file of columns, such as time.zero = "
                    "\"{0}\"",
                    clock_text(time_s), number_));

  zero_s_ = still_s_;
  line.remarks.push_back(at_line(
      fmt::format("the bottom block moves; time zero is {0}. Whoever starts this command again "
                  "gives the file of columns time.zero = \"{0}\"",
                  clock_text(*zero_s_))));
}

}  // namespace dccast::client
