#include "client/session/readings_columns.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include <toml++/toml.h>

#include "client/model/csv_line.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {

namespace {

/// How a measured value is named, and its unit in a reading.
struct Kind {
  Measured measured;
  std::string key;                    ///< in a file of columns
  std::vector<std::string> headings;  ///< in a table without such a file
  std::string unit;
  std::string example;  ///< a unit of plants
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {Measured::time, "time", {"time"}, "s", "s"},
      {Measured::cast_length, "length", {"length", "cast length"}, "m", "mm"},
      {Measured::casting_speed, "speed", {"speed", "casting speed"}, "m/s", "mm/min"},
      {Measured::casting_temperature, "metal", {"metal", "casting temperature"}, "degC", "degC"},
      {Measured::water_flow, "water", {"water"}, "m2/s", "l/min/m"},
      {Measured::narrow_water_flow, "narrow_water", {"narrow water"}, "m2/s", "l/min/m"},
      {Measured::second_water_flow, "second_water", {"second water"}, "m2/s", "l/min/m"},
      {Measured::water_temperature, "water_temperature", {"water temperature"}, "degC", "degC"},
      {Measured::metal_level, "metal_level", {"metal level"}, "m", "mm"},
      {Measured::curl, "curl", {}, "m", "mm"}};
  return all;
}

const Kind& kind_of(Measured measured) {
  return *std::ranges::find(kinds(), measured, &Kind::measured);
}

constexpr const char* total_flow = "m3/s";
constexpr const char* curl_begins = "curl ";  // before the monitor of a gauge

std::string reading_unit(const Column& column) {
  return column.per_m ? total_flow : kind_of(column.measured).unit;
}

bool is_flow(Measured measured) {
  return measured == Measured::water_flow || measured == Measured::narrow_water_flow ||
         measured == Measured::second_water_flow;
}

/// Reads a file of columns, and collects its faults.
class ColumnsReader {
public:
  explicit ColumnsReader(const std::string& name) : name_(name) {}

  ColumnMap read(const toml::table& table) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const auto kind = std::ranges::find(kinds(), name, &Kind::key);
      if (kind == kinds().end())
        refuse_unknown(node, name, name, keys_of_kinds());
      else if (kind->measured == Measured::curl)
        read_curls(node);
      else
        read_column(node, name, *kind, {});
    }

    // Faults of single keys first: a column that was refused would also be missed here.
    if (faults_.empty())
      if (const std::string fault = fault_among(map_.columns); !fault.empty())
        throw invalid(fmt::format("{}: {}", name_, fault));
    if (!faults_.empty()) throw invalid(joined_faults());
    return std::move(map_);
  }

private:
  std::string joined_faults() const {
    std::vector<std::string> texts;
    for (const auto& [place, text] : faults_) texts.push_back(text);
    return fmt::format("{}", fmt::join(texts, "\n"));
  }

  static std::vector<std::string> keys_of_kinds() {
    std::vector<std::string> keys;
    for (const Kind& kind : kinds()) keys.push_back(kind.key);
    return keys;
  }

  void refuse(const toml::node& node, const std::string& key, const std::string& fault) {
    std::ostringstream written;
    node.visit([&](const auto& value) { written << value; });
    const auto& place = node.source().begin;
    faults_.emplace(std::pair(place.line, place.column),
                    fmt::format("{}:{}:{}: {} = {}: {}", name_, place.line, place.column,
                                values::shown(key), values::shown(written.str()), fault));
  }

  void refuse_unknown(const toml::node& node, const std::string& path, const std::string& key,
                      const std::vector<std::string>& known) {
    const std::string near = case_file::nearest(key, known);
    refuse(node, path,
           fmt::format("unknown key; permitted: {}; {}", fmt::join(known, ", "),
                       near.empty() ? "remove it" : fmt::format("did you mean \"{}\"?", near)));
  }

  void read_curls(const toml::node& node) {
    const toml::table* const monitors = node.as_table();
    if (!monitors)
      return refuse(node, "curl",
                    "permitted: a table with the monitors of the case; write curl.MONITOR = { name "
                    "= \"...\", unit = \"mm\" }");
    for (const auto& [monitor, column] : *monitors)
      read_column(column, fmt::format("curl.{}", monitor.str()), kind_of(Measured::curl),
                  std::string(monitor.str()));
  }

  /// @param path  of its table in the file
  void read_column(const toml::node& node, const std::string& path, const Kind& kind,
                   const std::string& monitor) {
    const toml::table* const table = node.as_table();
    if (!table)
      return refuse(
          node, path,
          fmt::format("permitted: a table; write {} = {{ name = \"...\", unit = \"{}\" }}", path,
                      kind.example));

    Column column;
    column.measured = kind.measured;
    column.monitor = monitor;
    std::vector<std::string> known{"name", "unit"};
    if (is_flow(kind.measured)) known.push_back("per");
    if (kind.measured == Measured::time) known.push_back("zero");
    for (const auto& [key, value] : *table)
      if (std::ranges::find(known, key.str()) == known.end())
        refuse_unknown(value, fmt::format("{}.{}", path, key.str()), std::string(key.str()), known);

    // text_in() has refused a name that is there and is no text.
    column.name = text_in(*table, "name", path);
    column.unit = text_in(*table, "unit", path);
    if (column.name.empty() && !table->contains("name"))
      refuse(node, path, "name is missing; permitted: the name that the plant gives the column");
    if (table->contains("per")) read_per(*table, path, column);
    if (table->contains("zero")) read_zero(*table, column);
    check_unit(*table, node, path, column);
    map_.columns.push_back(std::move(column));
  }

  /// A text of a table; empty where it is missing, or is a fault.
  std::string text_in(const toml::table& table, const char* key, const std::string& path) {
    const toml::node* const node = table.get(key);
    if (!node) return {};
    const auto text = node->value<std::string>();
    if (text && !text->empty()) return *text;
    refuse(*node, fmt::format("{}.{}", path, key),
           "permitted: a text that is not empty, in quotes");
    return {};
  }

  void read_per(const toml::table& table, const std::string& path, Column& column) {
    const auto length = case_file::parse_quantity(text_in(table, "per", path), "m");
    if (length.value.value_or(0.0) > 0.0)
      column.per_m = length.value;
    else
      refuse(*table.get("per"), path + ".per",
             "permitted: a length above zero, such as \"5.2 m\"; give what the flow wets");
  }

  void read_zero(const toml::table& table, const Column& column) {
    const std::string text = text_in(table, "zero", "time");
    const auto seconds =
        column.unit.empty() ? std::nullopt : case_file::parse_quantity(text, "s").value;
    map_.zero.at_motion = text == "motion";
    if (map_.zero.at_motion) return;
    // A time without a unit is a time stamp, as in the column itself.
    const auto zero = seconds ? seconds : seconds_of_stamp(text);
    if (zero && std::abs(*zero) < longest_time_s)
      map_.zero.at_s = *zero;
    else
      refuse(
          *table.get("zero"), "time.zero",
          "permitted: \"motion\", or when the bottom block starts to move as a time stamp, such as "
          "\"2026-11-27T04:00:12Z\"; of times with a unit also \"1200 s\"");
  }

  /// @param node  of the column, for its place
  void check_unit(const toml::table& table, const toml::node& node, const std::string& path,
                  const Column& column) {
    const Kind& kind = kind_of(column.measured);
    if (column.unit.empty()) {
      if (table.contains("unit")) return;  // a fault already
      if (column.measured != Measured::time)
        refuse(node, path,
               fmt::format("unit is missing; permitted: the unit of the plant, such as \"{}\"",
                           kind.example));
      else if (!table.contains("zero"))
        refuse(node, path,
               "has neither unit nor zero; permitted: unit = \"s\" for times of the case, zero = "
               "\"motion\" for time stamps of a clock");
      return;
    }

    const std::string unit = reading_unit(column);
    if (case_file::convertible(column.unit, unit)) return;
    const bool is_total = is_flow(column.measured) && !column.per_m &&
                          case_file::convertible(column.unit, total_flow);
    refuse(*table.get("unit"), path + ".unit",
           is_total
               ? "is a flow in total; give the length that it wets, such as per = \"5.2 m\""
               : fmt::format("cannot be converted to {}; permitted: a unit such as \"{}\"; give "
                             "that of the plant",
                             unit, column.per_m ? "m3/h" : kind.example));
  }

  const std::string& name_;
  ColumnMap map_;
  /// By line and column; the parser gives the keys in alphabetical order.
  std::multimap<std::pair<toml::source_index, toml::source_index>, std::string> faults_;
};

/// "27.11.2026 04:00" as "2026-11-27 04:00"; another text as it is.
std::string with_year_first(const std::string& text) {
  std::smatch parts;
  static const std::regex day_first(R"((\d{1,2})\.(\d{1,2})\.(\d{4})(.*))");
  if (!std::regex_match(text, parts, day_first)) return text;
  const auto two_digits = [](const std::string& number) {
    return number.size() == 1 ? "0" + number : number;
  };
  return parts[3].str() + "-" + two_digits(parts[2].str()) + "-" + two_digits(parts[1].str()) +
         parts[4].str();
}

/// The zone at the end of a time: "+0100", "+01", " +01:00" and " UTC" as ISO 8601 with colons has
/// it; without one Z.
std::string with_usual_zone(const std::string& text) {
  std::smatch parts;
  static const std::regex zone(R"((.*?\d) ?(?:([Zz]|UTC|GMT)|([+-]\d\d):?(\d\d)?)?)");
  if (!std::regex_match(text, parts, zone)) return text;
  if (!parts[3].matched) return parts[1].str() + "Z";
  return parts[1].str() + parts[3].str() + ":" + (parts[4].matched ? parts[4].str() : "00");
}

}  // namespace

std::optional<Column> column_of_heading(const std::string& heading) {
  const auto parts = heading_of(heading);
  if (!parts) return std::nullopt;

  // Monitors are named as in the case; the quantities may be written in any letters.
  const std::string name = lowered(parts->name);
  const bool is_curl = name.starts_with(curl_begins);
  // "curl corner" names the monitor behind the quantity; all others have fixed headings.
  const auto kind = std::ranges::find_if(kinds(), [&](const Kind& each) {
    return is_curl ? each.measured == Measured::curl
                   : std::ranges::find(each.headings, name) != each.headings.end();
  });
  if (kind == kinds().end()) return std::nullopt;

  if (!case_file::convertible(parts->unit, kind->unit))
    throw invalid(fmt::format(
        "[{}] of \"{}\" cannot be converted to {}; permitted: a unit such as "
        "{}",
        values::shown(parts->unit), values::shown(parts->name), kind->unit, kind->example));
  Column column;
  column.name = heading;
  column.measured = kind->measured;
  column.unit = parts->unit;
  if (is_curl) column.monitor = trimmed(parts->name.substr(std::string(curl_begins).size()));
  return column;
}

std::string fault_among(const std::vector<Column>& columns) {
  const auto count = [&](Measured measured) {
    return std::ranges::count(columns, measured, &Column::measured);
  };
  if (count(Measured::time) != 1 || columns.size() < 2)
    return "a column for the time and one for a lever or a curl are needed";
  // The speed follows from the cast length, so the two could contradict each other.
  if (count(Measured::cast_length) > 0 && count(Measured::casting_speed) > 0)
    return "speed and cast length are both given; leave one of them out";

  for (std::size_t i = 0; i < columns.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (columns[i].measured == columns[j].measured && columns[i].monitor == columns[j].monitor)
        return fmt::format("\"{}\" and \"{}\" measure the same; leave one of them out",
                           values::shown(columns[j].name), values::shown(columns[i].name));
  return {};
}

ColumnMap parse_columns(const std::string& text, const std::string& name) {
  if (const auto fault = case_file::check_text(text))
    throw invalid(fmt::format("{}:{}:{}: {}; {}", name, fault->position.line,
                              fault->position.column, fault->message, fault->remedy));

  // Texts that would exhaust memory or stack were refused above.
  toml::table table;
  try {
    table = toml::parse(text, std::string_view(name));
  } catch (const toml::parse_error& error) {
    const auto& place = error.source().begin;
    throw invalid(fmt::format("{}:{}:{}: not valid TOML: {}", name, place.line, place.column,
                              values::shortened(error.description(), 200)));
  }
  return ColumnsReader(name).read(table);
}

std::optional<ColumnMap> read_columns(const std::string& file) {
  if (file.empty()) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw invalid(fmt::format("{} cannot be read; give the file of columns (docs/plc.md)", file));
  std::ostringstream text;
  text << stream.rdbuf();
  return parse_columns(text.str(), file);
}

double converted(double value, const Column& column) {
  const double number = case_file::convert(value, column.unit, reading_unit(column)).value();
  return number / column.per_m.value_or(1.0);
}

std::optional<double> seconds_of_stamp(std::string text) {
  constexpr std::size_t date = 10;     // characters of "2026-11-27"
  constexpr std::size_t longest = 64;  // of a time stamp
  if (text.size() <= date || text.size() > longest) return std::nullopt;
  text = with_year_first(text);
  if (text[date] != ' ' && text[date] != 'T' && text[date] != 't') return std::nullopt;
  // A sign in the date is no zone.
  std::string time = with_usual_zone(text.substr(date + 1));
  if (const auto comma = time.find(','); comma != std::string::npos) time[comma] = '.';
  text = text.substr(0, date) + "T" + time;

  google::protobuf::Timestamp stamp;
  if (!google::protobuf::util::TimeUtil::FromString(text, &stamp)) return std::nullopt;
  const double seconds = static_cast<double>(stamp.seconds()) + 1e-9 * stamp.nanos();
  return std::abs(seconds) < longest_time_s ? std::optional(seconds) : std::nullopt;
}

std::string stamp_of_seconds(double seconds) {
  return google::protobuf::util::TimeUtil::ToString(
      google::protobuf::util::TimeUtil::MillisecondsToTimestamp(std::llround(1e3 * seconds)));
}

}  // namespace dccast::client
