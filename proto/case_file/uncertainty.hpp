#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

/// How far the data of a case may be off: `[uncertainty]` of the case, that of its alloy card, and
/// the ranges of the schema's own defaults. docs/uncertainty.md.
namespace dccast::case_file {

/// What a range asks of its key.
struct Range {
  std::string suffix;     ///< ".scale", ".offset", or empty: the value itself
  std::string low, high;  ///< of KEY + suffix, as in a case file
};

inline constexpr const char* range_forms =
    "\"± 10 %\", \"± 5 K\", \"200..300 degC\" or \"0.5..2 times\"";

/// Reads a range; "+-" stands for "±". Units are not judged. @return empty for what is none
std::optional<Range> parse_range(std::string_view text);

/// A datum that may be off.
struct UncertainKey {
  std::string key;     ///< its path
  std::string range;   ///< as written
  std::string origin;  ///< "case", "card", "default"
  Range ends;

  std::string change() const { return key + ends.suffix; }
};

/// Every datum of a complete case that has a range. What gives the value gives its range: that of a
/// card or default does not hold for a value of the case, and where several stand, that of the case
/// does. Defaults that the case has no use for are left out.
std::vector<UncertainKey> uncertain_keys(const v1::Case& complete);

/// What is wrong with the ranges that a complete case gives, "uncertainty.KEY": an unknown key, a
/// wrong unit, an end that the key does not permit, a value outside of its own range.
std::vector<v1::Fault> uncertainty_faults(const v1::Case& complete);

/// The same of a card. @param alloy  as in its file
std::vector<v1::Fault> uncertainty_faults(const v1::Alloy& alloy);

}  // namespace dccast::case_file
