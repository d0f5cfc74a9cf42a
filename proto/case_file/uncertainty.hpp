#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

/// Uncertainty of the data of a case: `[uncertainty]` of the case and of its alloy card, and the
/// ranges of the defaults in the schema. docs/uncertainty.md.
namespace dccast::case_file {

/// The two ends of a range, as changes of its key.
struct Range {
  std::string suffix;     ///< ".scale", ".offset", or empty: the value itself
  std::string low, high;  ///< of KEY + suffix, as in a case file
};

/// Forms of a range, for messages.
inline constexpr const char* range_forms =
    "\"± 10 %\", \"± 5 K\", \"200..300 degC\" or \"0.5..2 times\"";

/// Parses a range; "+-" may be written for "±". Units are not checked.
/// @return empty if the text is not a range
std::optional<Range> parse_range(std::string_view text);

/// An uncertain datum.
struct UncertainKey {
  std::string key;     ///< its path
  std::string range;   ///< as written
  std::string origin;  ///< "case", "card", "default"
  Range ends;

  /// Key of the change that moves the datum, such as "alloy.specific_heat.scale".
  std::string change() const { return key + ends.suffix; }
};

/// All data of a complete case that have a range. The range comes from the same source as the
/// value: that of a card or default does not hold for a value of the case. If there are several,
/// that of the case counts. Defaults that do not affect the case are left out.
std::vector<UncertainKey> uncertain_keys(const v1::Case& complete);

/// Faults of the ranges that a complete case gives, "uncertainty.KEY": an unknown key, a wrong
/// unit, an end that the key does not permit, a value outside its own range.
std::vector<v1::Fault> uncertainty_faults(const v1::Case& complete);

/// Faults of the ranges of an alloy card. @param alloy  as in its file
std::vector<v1::Fault> uncertainty_faults(const v1::Alloy& alloy);

}  // namespace dccast::case_file
