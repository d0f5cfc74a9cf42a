#include "core/casting/findings/judge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/casting/findings/rules.hpp"

namespace dccast::casting {

namespace {

using results::Exceedance;

/// The finding that an exceeded limit raises.
Finding make_finding(const StepRule& rule, const Exceeded& found, double time) {
  Finding finding;
  finding.code = rule.code;
  finding.severity = rule.severity;
  finding.message = found.meaning;
  finding.time = time;
  finding.place = found.figure.place;

  // Figures that are not finite are left out of files and messages.
  if (std::isfinite(found.figure.value)) {
    finding.value = found.figure.value;
    finding.limit = found.limit;
    finding.worst = Exceedance{time, found.figure.value, found.figure.place};
  }

  finding.unit = rule.unit;
  finding.key = rule.key;
  return finding;
}

/// Updates the worst exceedance of a finding. Rows of one code differ in their key; figures of
/// different keys are not compared.
void update_worst(const StepRule& rule, const Exceeded& found, double time, Finding& raised) {
  if (raised.key != rule.key || !raised.worst) return;
  const double value = found.figure.value;
  const bool worse =
      rule.limit == Limit::upper ? value > raised.worst->value : value < raised.worst->value;
  if (worse) raised.worst = Exceedance{time, value, found.figure.place};
}

/// Draws the consequence of a finding that was raised: records a loss of validity.
/// @return the failure that follows, if any
std::optional<RunFailure> apply_consequence(const Case& c, const StepRule& rule,
                                            const Exceeded& found, const StepFigures& step,
                                            FindingsState& state) {
  if (!rule.consequence) return std::nullopt;

  // The first loss of validity is kept: it may be the cause of later ones.
  if (ends_run(*rule.consequence)) {
    if (state.lost) return std::nullopt;
    state.lost = {name_of(*rule.consequence), found.account, step.time, found.figure.place,
                  found.figure.value,         found.limit,   rule.unit};
    if (c.validity.when_lost == WhenLost::go_on) return std::nullopt;
  }

  return RunFailure{.kind = *rule.consequence,
                    .message = found.account,
                    .time = step.time,
                    .time_step = step.time_step,
                    .place = found.figure.place,
                    .residual_history = {},
                    .finding = rule.code};
}

}  // namespace

std::vector<Finding> findings_of_case(const Case& c) {
  const Course course = course_of(c);
  std::vector<Finding> raised;
  for (const CaseRule& rule : case_rules())
    if (auto finding = rule.judge(c, course)) {
      finding->code = rule.code;
      finding->severity = rule.severity;
      raised.push_back(std::move(*finding));
    }
  return raised;
}

RunFailures judge(const Case& c, const StepFigures& step, FindingsState& state) {
  RunFailures failures;
  for (const StepRule& rule : step_rules()) {
    const auto found = rule.judge(c, step);
    if (!found) continue;

    // A finding is raised once; later steps only update its worst value.
    const auto before = std::ranges::find(state.raised, rule.code, &Finding::code);
    if (before != state.raised.end()) {
      update_worst(rule, *found, step.time, *before);
      continue;
    }

    state.raised.push_back(make_finding(rule, *found, step.time));
    if (auto failure = apply_consequence(c, rule, *found, step, state))
      add_failure(failures, std::move(*failure));
  }
  return failures;
}

}  // namespace dccast::casting
