#include "core/findings/run_failure.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace dccast::casting {

namespace {

struct NamedKind {
  FailureKind kind;
  const char* name;
};

constexpr std::array<NamedKind, 7> names{{
    {FailureKind::solve_failed, "solve_failed"},
    {FailureKind::check_failed, "check_failed"},
    {FailureKind::shell_melted_through, "shell_melted_through"},
    {FailureKind::motion_too_large, "motion_too_large"},
    {FailureKind::liquid_pressure_lost, "liquid_pressure_lost"},
    {FailureKind::storage, "storage"},
    {FailureKind::other_version, "other_version"},
}};

}  // namespace

std::string name_of(FailureKind kind) {
  return std::ranges::find(names, kind, &NamedKind::kind)->name;
}

std::optional<FailureKind> failure_kind(std::string_view name) {
  const auto found = std::ranges::find(names, name, &NamedKind::name);
  return found == names.end() ? std::nullopt : std::optional(found->kind);
}

bool ends_run(FailureKind kind) {
  return kind != FailureKind::check_failed;
}

void add_failure(RunFailures& failures, RunFailure failure) {
  const auto same = std::ranges::find(failures, failure.kind, &RunFailure::kind);
  if (same == failures.end()) failures.push_back(std::move(failure));
}

std::string in_words(const RunFailures& failures) {
  std::string text;
  for (const RunFailure& failure : failures)
    text +=
        text.empty() ? failure.message : "; then " + name_of(failure.kind) + ": " + failure.message;
  return text;
}

}  // namespace dccast::casting
