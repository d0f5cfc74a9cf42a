// Measurements that `dccast calibrate` reads.
#include <sstream>

#include "client/model/measured_csv.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::istringstream stream{std::string(fuzz::text_of(bytes, size))};
  const auto file = client::read_measured(stream, "curl.csv", {"corner", "thermocouple"});
  fuzz::require(!file.faults.empty() || !file.curves.empty(), "there are curves or faults");
  return 0;
}
