// The settings of dccastd: a line as --set has it, then a file.
#include "server/daemon/settings.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text = fuzz::text_of(bytes, size);
  const std::size_t end = std::min(text.find('\n'), text.size());
  try {
    daemon::read_config(fuzz::file_with(text.substr(std::min(end + 1, text.size()))),
                        {std::string(text.substr(0, end))});
  } catch (const daemon::InvalidConfig&) {
  }
  return 0;
}
