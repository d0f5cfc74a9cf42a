#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dccast::results {

enum class Severity { note, warning, danger };

/// Something about a casting that an engineer should know: message Finding of job.proto. Every code
/// stands in docs/findings.md.
struct Finding {
  std::string code;  ///< e.g. "no_superheat"
  Severity severity = Severity::warning;
  std::string message;          ///< one sentence: what it means in the pit
  std::optional<double> time;   ///< [s] when first seen; nothing: from the case alone
  std::vector<double> place;    ///< in the undeformed slab [m]; empty where there is none
  std::optional<double> value;  ///< in `unit`
  std::optional<double> limit;  ///< in `unit`
  std::string unit;
  std::string key;  ///< of the case, that sets the limit or is at odds
  bool operator==(const Finding&) const = default;
};

/// "note", "warning" or "danger".
inline const char* name_of(Severity severity) {
  constexpr const char* names[] = {"note", "warning", "danger"};
  return names[static_cast<int>(severity)];
}

}  // namespace dccast::results
