// A case file. One without a fault is a sound case, and reads back from what is written of it.
#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  v1::Case read;
  const auto outcome = case_file::read_elsewhere(fuzz::text_of(bytes, size), "case", read);
  for (const v1::Fault& fault : outcome.faults)
    fuzz::require(fault.ByteSizeLong() < 2000, "faults are short");
  if (!outcome.ok()) return 0;
  fuzz::require(case_file::check_ranges(read).empty(), "a file without a fault is in range");
  v1::Case again;
  fuzz::require(case_file::read_elsewhere(case_file::to_toml(read), "again", again).ok(),
                "what is written can be read");
  fuzz::require(read.SerializeAsString() == again.SerializeAsString(), "it reads back the same");
  return 0;
}
