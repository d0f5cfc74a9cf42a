#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/casting/case/case.hpp"
#include "core/casting/case/casting_schedule.hpp"
#include "core/casting/findings/figures.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/results/step_report.hpp"

/// Every finding is one row of a table, with the function that judges it: rules_of_case.cpp and
/// rules_of_step.cpp. docs/findings.md has their limits, sources and practical meaning; a new one
/// needs a row here and a row there.
namespace dccast::casting {

using results::Finding;
using results::Severity;

/// A figure beside its limit.
struct Judged {
  PlacedFigure figure;  ///< [unit of the rule]
  double limit = 0.0;   ///< [unit of the rule]
  std::string meaning;  ///< one sentence: what it means in practice if it is beyond the limit
  /// Message of the failure or of the loss of validity; only of rules with a consequence.
  std::string account{};
  bool is_beyond = false;  ///< whatever the figure: the rule has found out
};

/// Whether a figure must not be above its limit, or not below it.
enum class Limit { upper, lower };

/// A rule that judges the figures of a step. A code may have several rows that share its meaning
/// and differ in their key: the first one whose figure is beyond the limit raises it.
struct StepRule {
  /// Name of the finding in results and on the command line.
  const char* code;
  Severity severity;
  /// The failure that follows: at once if it ends_run(), else at the end of the run. A failure that
  /// ends the run is a loss of validity; with validity.when_lost = go_on the run continues and its
  /// results are marked instead.
  std::optional<FailureKind> consequence;
  const char* key;   ///< key of the case that sets the limit; empty for a bound of the program
  const char* unit;  ///< of figure and limit
  Limit limit;
  const char* figure;  ///< by which the case has its error; empty: it has none
  /// Empty where the rule does not apply.
  std::optional<Judged> (*judge)(const Case&, const StepFigures&);
};

/// A rule that follows from the tables of a case alone.
struct CaseRule {
  const char* code;
  Severity severity;
  /// The finding without code and severity.
  std::optional<Finding> (*judge)(const Case&, const Course&);
};

/// The rules in the order in which findings of the same step are raised: causes before their
/// effects. The first row that ends the run names the loss of validity.
std::span<const StepRule> step_rules();
/// All rules of a case, in the order in which they are judged.
std::span<const CaseRule> case_rules();

inline constexpr double in_mm = 1e3;  ///< [mm/m] for messages

}  // namespace dccast::casting
