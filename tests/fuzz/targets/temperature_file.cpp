// An attachment with prescribed temperatures.
#include "core/results/temperature_file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  Faults faults;
  constexpr std::size_t nodes = 3;
  const auto history =
      results::read_temperature_file(fuzz::file_with(fuzz::text_of(bytes, size)), nodes, faults);
  fuzz::require(history.has_value() == faults.list().empty(), "there are temperatures or a fault");
  if (!history) return 0;
  fuzz::require(history->nodes() == nodes, "every node has a temperature");
  std::vector<double> temperature;
  history->at(0.5 * (history->begin() + history->end()), temperature);
  return 0;
}
