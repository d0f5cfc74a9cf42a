#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::results {

enum class Severity { note, warning, danger };

/// A figure beyond its limit.
struct Exceedance {
  double time = 0.0;          ///< [s] end of the step
  double value = 0.0;         ///< [unit of the finding]
  std::vector<double> place;  ///< in the undeformed slab [m]; empty where there is none
  bool operator==(const Exceedance&) const = default;
};

/// A finding about a casting that an engineer should know, see message Finding of job.proto.
/// docs/findings.md lists all codes.
struct Finding {
  std::string code;  ///< e.g. "no_superheat"
  Severity severity = Severity::warning;
  std::string message;          ///< one sentence: what it means in practice
  std::optional<double> time;   ///< [s] when first found; absent: follows from the case alone
  std::vector<double> place;    ///< in the undeformed slab [m]; empty where there is none
  std::optional<double> value;  ///< [`unit`] when first found
  std::optional<double> limit;  ///< [`unit`]
  std::string unit;
  std::string key;  ///< key of the case that sets the limit or causes the finding; empty: none does
  /// The figure farthest beyond the limit so far; absent if the finding has no time or no value.
  std::optional<Exceedance> worst = std::nullopt;
  bool operator==(const Finding&) const = default;
};

/// "note", "warning" or "danger".
inline const char* name_of(Severity severity) {
  constexpr const char* names[] = {"note", "warning", "danger"};
  return names[static_cast<int>(severity)];
}

}  // namespace dccast::results
