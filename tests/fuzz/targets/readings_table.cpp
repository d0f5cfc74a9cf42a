// What a plant measures, as `dccast follow` reads it.
#include <cmath>

#include "client/session/failure.hpp"
#include "client/session/readings_csv.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = fuzz::text_of(bytes, size);
  client::ReadingsTable table;
  double last_s = -INFINITY;
  try {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const auto line = table.take(std::string(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (!line.reading) continue;
      fuzz::require(line.reading->time_s() > last_s, "readings have rising times");
      last_s = line.reading->time_s();
    }
  } catch (const client::CommandFailed&) {
    fuzz::require(!std::isfinite(last_s), "a table ends at its header alone");
  }
  return 0;
}
