#include "core/findings/judge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/findings/rules.hpp"

namespace dccast::casting {

namespace {

using results::Exceedance;

Finding finding_of(const StepRule& rule, const Exceeded& found, double time) {
  Finding finding;
  finding.code = rule.code;
  finding.severity = rule.severity;
  finding.message = found.meaning;
  finding.time = time;
  finding.place = found.figure.place;
  // A figure that is not a number has no place in a file or on the wire.
  if (std::isfinite(found.figure.value)) {
    finding.value = found.figure.value;
    finding.limit = found.limit;
    finding.worst = Exceedance{time, found.figure.value, found.figure.place};
  }
  finding.unit = rule.unit;
  finding.key = rule.key;
  return finding;
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

// The state of the judge in a checkpoint.

namespace {

using results::Sections;

/// Of what may be absent: nothing or one value.
Sections::Reals as_reals(const std::optional<double>& value) {
  return value ? Sections::Reals{*value} : Sections::Reals{};
}

/// @throws std::out_of_range  more than one value
std::optional<double> as_optional(const Sections& s, const std::string& name) {
  const Sections::Reals& values = s.reals(name);
  if (values.size() > 1) throw std::out_of_range("'" + name + "' is more than one number");
  return values.empty() ? std::nullopt : std::optional(values.front());
}

/// Time, value and coordinates in one array.
Sections::Reals as_reals(const std::optional<Exceedance>& worst) {
  if (!worst) return {};
  Sections::Reals values{worst->time, worst->value};
  values.insert(values.end(), worst->place.begin(), worst->place.end());
  return values;
}

/// @throws std::out_of_range  not as of a finding: one of a step with a value has it, no other
std::optional<Exceedance> worst_of(const Finding& finding, const Sections::Reals& values) {
  if (values.empty() == (finding.time && finding.value) || values.size() == 1)
    throw std::out_of_range("the worst exceedance of a finding is not one");
  if (values.empty()) return std::nullopt;
  return Exceedance{values[0], values[1], {values.begin() + 2, values.end()}};
}

void write_finding(const Finding& finding, const std::string& prefix, Sections& s) {
  s.set(prefix + "code", finding.code);
  s.set_integer(prefix + "severity", static_cast<std::int64_t>(finding.severity));
  s.set(prefix + "message", finding.message);
  s.set(prefix + "time_s", as_reals(finding.time));
  s.set(prefix + "place_m", finding.place);
  s.set(prefix + "value", as_reals(finding.value));
  s.set(prefix + "limit", as_reals(finding.limit));
  s.set(prefix + "unit", finding.unit);
  s.set(prefix + "key", finding.key);
  s.set(prefix + "worst", as_reals(finding.worst));
}

Finding read_finding(const Sections& s, const std::string& prefix) {
  const std::int64_t severity = s.integer(prefix + "severity");
  if (severity < 0 || severity > 2) throw std::out_of_range("unknown severity of a finding");
  Finding finding{s.text(prefix + "code"),
                  static_cast<Severity>(severity),
                  s.text(prefix + "message"),
                  as_optional(s, prefix + "time_s"),
                  s.reals(prefix + "place_m"),
                  as_optional(s, prefix + "value"),
                  as_optional(s, prefix + "limit"),
                  s.text(prefix + "unit"),
                  s.text(prefix + "key")};
  finding.worst = worst_of(finding, s.reals(prefix + "worst"));
  return finding;
}

std::string prefix_of(std::size_t number) {
  return "finding." + std::to_string(number) + '/';
}

void write_loss(const std::optional<ValidityLoss>& lost, Sections& s) {
  s.set_integer("validity/lost", lost ? 1 : 0);
  if (!lost) return;
  s.set("validity/kind", lost->kind);
  s.set("validity/message", lost->message);
  s.set("validity/unit", lost->unit);
  s.set("validity/place_m", lost->place);
  s.set("validity/time_value_limit", Sections::Reals{lost->time, lost->value, lost->limit});
}

std::optional<ValidityLoss> read_loss(const Sections& s) {
  if (s.integer("validity/lost") == 0) return std::nullopt;
  const auto& numbers = s.reals("validity/time_value_limit");
  return ValidityLoss{s.text("validity/kind"), s.text("validity/message"),
                      numbers.at(0),           s.reals("validity/place_m"),
                      numbers.at(1),           numbers.at(2),
                      s.text("validity/unit")};
}

}  // namespace

void write_findings(const FindingsState& state, Sections& s) {
  s.set_integer("figures/shell_stood", state.history.shell_stood ? 1 : 0);
  s.set("figures/when_liquid", state.history.when_liquid);
  s.set_real("figures/thickest_bottom_shell_m", state.history.thickest_bottom_shell);
  write_loss(state.lost, s);
  s.set_integer("findings", static_cast<std::int64_t>(state.raised.size()));
  for (std::size_t i = 0; i < state.raised.size(); ++i)
    write_finding(state.raised[i], prefix_of(i), s);
}

FindingsState read_findings(const Sections& s) {
  FindingsState state;
  state.history.shell_stood = s.integer("figures/shell_stood") != 0;
  state.history.when_liquid = s.reals("figures/when_liquid");
  state.history.thickest_bottom_shell = s.real("figures/thickest_bottom_shell_m");
  state.lost = read_loss(s);
  const auto count = static_cast<std::size_t>(s.integer("findings"));
  for (std::size_t i = 0; i < count; ++i) state.raised.push_back(read_finding(s, prefix_of(i)));
  return state;
}

}  // namespace dccast::casting
