// An alloy card, with its ranges of uncertainty.
#include "dccast/v1/case.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  v1::Alloy card, overrides;
  const auto outcome = case_file::read_elsewhere(fuzz::text_of(bytes, size), "card", card);
  case_file::uncertainty_faults(card);
  case_file::complete_alloy(card, overrides);
  if (outcome.ok()) case_file::key_values(overrides);
  return 0;
}
