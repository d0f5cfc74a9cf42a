#include "core/findings/judge.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/findings/rules.hpp"

namespace dccast::casting {

namespace {

using results::Exceedance;

/// A figure that is not a number has no place in a file or on the wire.
std::optional<double> number(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

Finding finding_of(const StepRule& rule, const Exceeded& found, double time) {
  Finding finding;
  finding.code = rule.code;
  finding.severity = rule.severity;
  finding.message = found.meaning;
  finding.time = time;
  finding.place = found.figure.place;
  finding.value = number(found.figure.value);
  if (finding.value) {
    finding.limit = found.limit;
    finding.worst = Exceedance{time, found.figure.value, found.figure.place};
  }
  finding.unit = rule.unit;
  finding.key = rule.key;
  return finding;
}

ValidityLoss loss_of(const StepRule& rule, const Exceeded& found, double time) {
  return {name_of(*rule.consequence), found.account, time,     found.figure.place,
          found.figure.value,         found.limit,   rule.unit};
}

RunFailure failure_of(const StepRule& rule, const Exceeded& found, const StepFigures& step) {
  RunFailure failure;
  failure.kind = *rule.consequence;
  failure.finding = rule.code;
  failure.message = found.account;
  failure.time = step.time;
  failure.time_step = step.time_step;
  failure.place = found.figure.place;
  return failure;
}

/// Rows of one code differ in their key; figures of different keys are not compared.
void keep_worst(const StepRule& rule, const Exceeded& found, double time, Finding& raised) {
  if (raised.key != rule.key || !raised.worst) return;
  const double value = found.figure.value;
  const bool worse =
      rule.limit == Limit::upper ? value > raised.worst->value : value < raised.worst->value;
  if (worse) raised.worst = Exceedance{time, value, found.figure.place};
}

/// @return  the failure that follows from a finding that was raised, if any
std::optional<RunFailure> consequence_of(const Case& c, const StepRule& rule, const Exceeded& found,
                                         const StepFigures& step, FindingsState& state) {
  if (!rule.consequence) return std::nullopt;
  if (!ends_run(*rule.consequence)) return failure_of(rule, found, step);
  if (state.lost) return std::nullopt;
  state.lost = loss_of(rule, found, step.time);
  if (c.validity.when_lost == WhenLost::go_on) return std::nullopt;
  return failure_of(rule, found, step);
}

}  // namespace

std::vector<Finding> findings_of_case(const Case& c) {
  const Course course = course_of(c);
  std::vector<Finding> raised;
  for (const CaseRule& rule : case_rules()) {
    auto finding = rule.judge(c, course);
    if (!finding) continue;
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
    const auto before = std::ranges::find(state.raised, rule.code, &Finding::code);
    if (before != state.raised.end()) {
      keep_worst(rule, *found, step.time, *before);
      continue;
    }
    state.raised.push_back(finding_of(rule, *found, step.time));
    if (auto failure = consequence_of(c, rule, *found, step, state))
      add_failure(failures, std::move(*failure));
  }
  return failures;
}

}  // namespace dccast::casting
