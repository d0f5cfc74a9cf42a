// What a plant measures, as `dccast follow` reads it: rows or JSON objects, after a file of columns
// or without one. A line "---" ends the file of columns.
#include <cmath>

#include "client/session/failure.hpp"
#include "client/session/readings_table.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

namespace {

constexpr std::string_view columns_end = "\n---\n";

/// The file of columns before the lines, which is taken off. @throws CommandFailed
std::optional<client::ColumnMap> take_columns(std::string_view& text) {
  const std::size_t end = text.find(columns_end);
  if (end == std::string_view::npos) return std::nullopt;
  const std::string columns(text.substr(0, end));
  text.remove_prefix(end + columns_end.size());
  return client::parse_columns(columns, "columns.toml");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  double last_s = -INFINITY;
  try {
    client::ReadingsTable table(take_columns(text));
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const auto line = table.take(std::string(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
      fuzz::require(line.readings.size() <= 5000, "a line holds what waited, and an hour's speeds");
      for (const client::ReadingOfLine& each : line.readings) {
        fuzz::require(each.reading.time_s() > last_s, "readings have rising times");
        last_s = each.reading.time_s();
      }
    }
  } catch (const client::CommandFailed&) {  // also of a second header that lacks a column
  }
  return 0;
}
