#include "core/casting/findings/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/casting/findings/rules.hpp"

namespace dccast::casting {

namespace {

using results::Certainty;
using results::Exceedance;

/// The figure of a rule, with the bounds between which mesh and steps leave the true one.
struct Bounded {
  double value, least, most;  ///< [unit of the rule]
  bool has_error;
};

Bounded bounded(const Case& c, const StepRule& rule, double value) {
  const auto known = c.figure_errors.find(rule.figure);
  if (known == c.figure_errors.end()) return {value, value, value, false};
  const FigureError& error = known->second;
  const double scale = error.is_relative ? std::abs(value) : 1.0;
  return {value, value - scale * error.below, value + scale * error.above, true};
}

/// "4.9 mm": as engineers have it.
std::string in_plant_unit(double value, const std::string& unit) {
  if (unit == "m") return fmt::format("{:.3g} mm", in_mm * value);
  if (unit == "rad") return fmt::format("{:.3g} degrees", value * 180.0 / std::numbers::pi);
  if (unit == "1") return fmt::format("{:.3g}", value);
  return fmt::format("{:.4g} {}", value, unit);
}

/// How far a figure is from its limit; below zero beyond it. [unit of the rule]
double distance(Limit limit, double value, double bound) {
  return limit == Limit::upper ? bound - value : value - bound;
}

/// What is no number is beyond every limit. @return  empty: even the true figure keeps its limit
std::optional<Certainty> certainty_of(const StepRule& rule, const Judged& found,
                                      const Bounded& figure) {
  const auto keeps = [&](double value) {
    return !found.is_beyond && distance(rule.limit, value, found.limit) >= 0.0;
  };
  const bool is_upper = rule.limit == Limit::upper;
  if (keeps(is_upper ? figure.most : figure.least)) return std::nullopt;
  if (keeps(figure.value)) return Certainty::open;
  return keeps(is_upper ? figure.least : figure.most) ? Certainty::likely : Certainty::sure;
}

/// What a finding means, and what mesh and steps leave open of it.
std::string message_of(const StepRule& rule, const Judged& found, const Bounded& figure,
                       Certainty certainty) {
  if (certainty == Certainty::sure) return found.meaning;
  const std::string range =
      in_plant_unit(figure.least, rule.unit) + " to " + in_plant_unit(figure.most, rule.unit);
  if (certainty == Certainty::likely)
    return fmt::format("{} Likely, not sure: mesh and steps leave {}.", found.meaning, range);
  return fmt::format("Cannot be told: the {} is {}, mesh and steps leave {}, the limit is {}.",
                     rule.figure, in_plant_unit(figure.value, rule.unit), range,
                     in_plant_unit(found.limit, rule.unit));
}

void update_margin(const StepRule& rule, const Judged& found, double time,
                   std::vector<Margin>& margins) {
  if (found.is_beyond || !std::isfinite(found.figure.value)) return;
  const auto known = std::ranges::find_if(
      margins, [&](const Margin& each) { return each.code == rule.code && each.key == rule.key; });

  Margin margin{rule.code, rule.key, rule.unit, found.limit,
                Exceedance{time, found.figure.value, found.figure.place}};
  if (known == margins.end())
    margins.push_back(std::move(margin));
  else if (distance(rule.limit, margin.worst.value, margin.limit) <
           distance(rule.limit, known->worst.value, known->limit))
    *known = std::move(margin);
}

/// The worst figure of a finding so far.
void set_worst(const Judged& found, const Bounded& figure, double time, Finding& finding) {
  finding.worst = Exceedance{time, figure.value, found.figure.place};
  if (!figure.has_error) return;
  finding.lower_error = figure.value - figure.least;
  finding.upper_error = figure.most - figure.value;
}

/// The finding that an exceeded limit raises.
Finding make_finding(const StepRule& rule, const Judged& found, const Bounded& figure,
                     Certainty certainty, double time) {
  Finding finding;
  finding.code = rule.code;
  finding.severity = rule.severity;
  finding.message = message_of(rule, found, figure, certainty);
  if (figure.has_error) finding.certainty = certainty;
  finding.time = time;
  finding.place = found.figure.place;

  // Figures that are not finite are left out of files and messages.
  if (std::isfinite(found.figure.value)) {
    finding.value = found.figure.value;
    finding.limit = found.limit;
    set_worst(found, figure, time, finding);
  }

  finding.unit = rule.unit;
  finding.key = rule.key;
  return finding;
}

/// Updates a finding that was raised before. Rows of one code differ in their key; figures of
/// different keys are not compared, but what is more certain replaces what is less so.
void update(const StepRule& rule, const Judged& found, const Bounded& figure, Certainty certainty,
            double time, Finding& raised) {
  const bool is_surer = raised.certainty && certainty > *raised.certainty;
  if (raised.key != rule.key) {
    if (is_surer) raised = make_finding(rule, found, figure, certainty, time);
    return;
  }

  const bool is_worse =
      raised.worst && std::isfinite(figure.value) &&
      distance(rule.limit, figure.value, 0.0) < distance(rule.limit, raised.worst->value, 0.0);
  if (is_worse) set_worst(found, figure, time, raised);

  // What is open is said of the worst figure.
  if (is_surer || (is_worse && certainty != Certainty::sure)) {
    raised.message = message_of(rule, found, figure, certainty);
    raised.certainty = certainty;
  }
}

/// Draws the consequence of a finding that was raised: records a loss of validity.
/// @return the failure that follows, if any
std::optional<RunFailure> apply_consequence(const Case& c, const StepRule& rule,
                                            const Judged& found, const StepFigures& step,
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
    update_margin(rule, *found, step.time, state.margins);
    const Bounded figure = bounded(c, rule, found->figure.value);
    const auto certainty = certainty_of(rule, *found, figure);
    if (!certainty) continue;

    // A finding is raised once; later steps only update it.
    const auto before = std::ranges::find(state.raised, rule.code, &Finding::code);
    if (before != state.raised.end()) {
      update(rule, *found, figure, *certainty, step.time, *before);
      continue;
    }

    state.raised.push_back(make_finding(rule, *found, figure, *certainty, step.time));
    if (auto failure = apply_consequence(c, rule, *found, step, state))
      add_failure(failures, std::move(*failure));
  }
  return failures;
}

}  // namespace dccast::casting
