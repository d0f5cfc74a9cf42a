#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::results {

enum class Severity { note, warning, danger };

/// A finding about a casting that an engineer should know, see message Finding of job.proto.
/// docs/findings.md lists all codes.
struct Finding {
  std::string code;  ///< e.g. "no_superheat"
  Severity severity = Severity::warning;
  std::string message;          ///< one sentence: what it means in practice
  std::optional<double> time;   ///< [s] when first found; absent: follows from the case alone
  std::vector<double> place;    ///< in the undeformed slab [m]; empty where there is none
  std::optional<double> value;  ///< [`unit`]
  std::optional<double> limit;  ///< [`unit`]
  std::string unit;
  std::string key;  ///< key of the case that sets the limit or causes the finding
  bool operator==(const Finding&) const = default;
};

/// "note", "warning" or "danger".
inline const char* name_of(Severity severity) {
  constexpr const char* names[] = {"note", "warning", "danger"};
  return names[static_cast<int>(severity)];
}

}  // namespace dccast::results
