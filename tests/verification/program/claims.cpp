#include "tests/verification/program/claims.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/verification/program/named_tests.hpp"

namespace dccast::verification {

double figure(const Figures& figures, const std::string& key) {
  if (key == "displacement_error") return figures.displacement_error;
  if (key == "stress_error") return figures.stress_error;
  if (key == "iterations_per_step") return figures.iterations_per_step;
  const auto found = figures.more.find(key);
  return found == figures.more.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
}

const Result& Runs::of(const RunRequest& request) {
  const std::string command = command_of(request);
  const auto found = results_.find(command);
  if (found != results_.end()) return found->second;
  return results_.emplace(command, run_by_name(request)).first->second;
}

namespace {

bool holds(const Claim& claim, double measured) {
  switch (claim.relation) {
    case Relation::at_most:
      return measured <= claim.bound;
    case Relation::within:
      return std::abs(measured / claim.bound - 1.0) <= claim.tolerance;
    case Relation::fails_at:
      return std::abs(measured - claim.bound) <= 1e-9;
  }
  return false;
}

std::string text_of_bound(const Claim& claim) {
  char text[80];
  switch (claim.relation) {
    case Relation::at_most:
      std::snprintf(text, sizeof text, "<= %.8g", claim.bound);
      break;
    case Relation::within:
      std::snprintf(text, sizeof text, "%.8g within %g %%", claim.bound, 100.0 * claim.tolerance);
      break;
    case Relation::fails_at:
      std::snprintf(text, sizeof text, "fails at t = %g s", claim.bound);
      break;
  }
  return text;
}

}  // namespace

Verdict judge(const Claim& claim, Runs& runs) {
  const Result& result = runs.of(claim.request);
  Verdict verdict{&claim, std::numeric_limits<double>::quiet_NaN(), false, {}};
  const bool expects_failure = claim.relation == Relation::fails_at;
  if (const auto* failed = std::get_if<Failed>(&result)) {
    verdict.note = failed->why;
    if (!expects_failure) return verdict;
    verdict.measured = failed->time;
  } else if (expects_failure) {
    verdict.note = "the run did not fail";
    return verdict;
  } else {
    verdict.measured = figure(std::get<Figures>(result), claim.key);
  }
  verdict.passed = holds(claim, verdict.measured);
  return verdict;
}

Verdict judge_figure(const Claim& claim, double measured) {
  return {&claim, measured, holds(claim, measured), {}};
}

std::string miss_of(const Verdict& verdict) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", verdict.measured);
  return verdict.claim->what + ": " + text + ", to reach " + text_of_bound(*verdict.claim);
}

std::vector<const Claim*> claims_about(const RunRequest& request) {
  std::vector<const Claim*> about;
  for (const Claim& claim : claims()) {
    RunRequest asked = request;
    // What a method costs is claimed of that method only; what it solves is the same problem.
    if (claim.key != "iterations_per_step" && claim.relation != Relation::fails_at) {
      asked.algorithm = claim.request.algorithm;
    }
    if (claim.relation == Relation::fails_at || command_of(asked) != command_of(claim.request)) {
      continue;
    }
    about.push_back(&claim);
  }
  return about;
}

Table table_of(const std::vector<Verdict>& verdicts) {
  Table table;
  table.title = "Figures to reach";
  table.columns = {"figure", "reach", "ours", "verdict", "command"};
  for (const Verdict& v : verdicts) {
    std::string command = "`";
    command.append(command_of(v.claim->request)).append("`");
    table.rows.push_back({v.claim->what, text_of_bound(*v.claim),
                          std::isfinite(v.measured) ? Cell(v.measured) : Cell(v.note),
                          v.passed ? "pass" : "MISS", command});
  }
  return table;
}

}  // namespace dccast::verification
