#pragma once

#include <cstdio>
#include <optional>
#include <span>
#include <string>

#include "core/case/case.hpp"
#include "core/case/casting_schedule.hpp"
#include "core/findings/figures.hpp"
#include "core/findings/run_failure.hpp"
#include "core/results/step_report.hpp"

/// Every finding is one row of a table, with the function that judges it: rules_of_case.cpp and
/// rules_of_step.cpp. docs/findings.md has their limits, sources and practical meaning; a new one
/// needs a row here and a row there.
namespace dccast::casting {

using results::Finding;
using results::Severity;

/// A limit that is exceeded.
struct Exceeded {
  PlacedFigure figure;  ///< [unit of the rule]
  double limit = 0.0;   ///< [unit of the rule]
  std::string meaning;  ///< one sentence: what it means in practice
  /// Message of the failure or of the loss of validity; only of rules with a consequence.
  std::string account{};
};

enum class Limit { upper, lower };

/// A code may have several rows that share its meaning and differ in their key: whichever is
/// exceeded first raises it.
struct StepRule {
  const char* code;
  Severity severity;
  /// The failure that follows, at once if it ends_run(), else at the end of the run. One that ends
  /// the run is a loss of validity: with validity.when_lost = go_on the run is marked instead.
  std::optional<FailureKind> consequence;
  const char* key;   ///< of the case that sets the limit; empty for a bound of the program
  const char* unit;  ///< of figure and limit
  Limit limit;
  std::optional<Exceeded> (*judge)(const Case&, const StepFigures&);
};

/// A rule that follows from the tables of a case alone.
struct CaseRule {
  const char* code;
  Severity severity;
  /// The finding without code and severity.
  std::optional<Finding> (*judge)(const Case&, const Course&);
};

/// In the order in which findings of the same step are raised: causes before what they lead to. The
/// first row that ends the run names the loss of validity.
std::span<const StepRule> step_rules();
std::span<const CaseRule> case_rules();

/// Like printf, but returns a string.
template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[500];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

inline constexpr double in_mm = 1e3;  ///< [mm/m] for messages

}  // namespace dccast::casting
