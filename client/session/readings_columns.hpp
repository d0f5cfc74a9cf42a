#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::client {

/// What a plant measures for a reading.
enum class Measured {
  time,
  cast_length,  ///< the speed follows from its difference
  casting_speed,
  casting_temperature,
  water_flow,
  narrow_water_flow,
  second_water_flow,
  water_temperature,
  metal_level,
  curl
};

/// A column of a table, or a member of JSON objects, and how it is read.
struct Column {
  std::string name;  ///< as the source writes it
  Measured measured;
  std::string unit;               ///< of the source; empty: time stamps of a clock
  std::optional<double> per_m{};  ///< a flow in total, and the length that it wets [m]
  std::string monitor{};          ///< of a curl
};

/// When the bottom block starts to move, on the clock of the source.
struct TimeZero {
  bool at_motion = false;  ///< where the speed first rises; until then `at_s` is unknown
  double at_s = 0.0;       ///< [s] of that clock; of time stamps since 1970
};

/// The columns of a source with the plant's own names.
struct ColumnMap {
  std::vector<Column> columns;
  TimeZero zero;
};

/// "speed [mm/min]" as a column; empty: it is none that is read. @throws CommandFailed  its unit
/// does not fit
std::optional<Column> column_of_heading(const std::string& heading);

/// What is wrong with these columns together, with the remedy; empty: nothing.
std::string fault_among(const std::vector<Column>& columns);

/// Reads a file of columns (docs/plc.md); nothing where `file` is empty. @throws CommandFailed
/// every fault with its place, value, what is permitted and the remedy
std::optional<ColumnMap> read_columns(const std::string& file);
/// The same of a text. @param name  of its file, for messages
ColumnMap parse_columns(const std::string& text, const std::string& name);

/// Longest time on the clock of a source, some 300 years [s].
inline constexpr double longest_time_s = 1e10;

/// A value of a column in the unit of the message: s, m, m/s, degC or m2/s.
double converted(double value, const Column& column);

/// Seconds since 1970 of a time stamp of ISO 8601 such as "2026-11-27T04:00:12.5+01:00", also with
/// a blank for T, "+0100" or "+01", a comma before the decimals, and "27.11.2026 04:00:12"; without
/// a zone it counts as UTC. Empty: it is none, or ambiguous, as "11/27/2026".
std::optional<double> seconds_of_stamp(std::string text);
/// The time stamp of that many seconds since 1970, in UTC.
std::string stamp_of_seconds(double seconds);

}  // namespace dccast::client
