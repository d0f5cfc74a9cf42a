#include "core/casting/findings/run_failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace dccast::casting {

namespace {

/// In the order of FailureKind.
constexpr std::array names{"solve_failed",     "check_failed", "shell_melted_through",
                           "motion_too_large", "storage",      "other_version"};

}  // namespace

std::string name_of(FailureKind kind) {
  return names[std::size_t(kind)];
}

std::optional<FailureKind> failure_kind(std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<FailureKind>(found - names.begin());
}

bool ends_run(FailureKind kind) {
  return kind != FailureKind::check_failed;
}

void add_failure(RunFailures& failures, RunFailure failure) {
  const auto same = std::ranges::find(failures, failure.kind, &RunFailure::kind);
  if (same == failures.end()) failures.push_back(std::move(failure));
}

std::string in_words(const RunFailures& failures) {
  if (failures.empty()) return "";
  std::string text = failures.front().message;
  for (std::size_t i = 1; i < failures.size(); ++i)
    text += fmt::format("; then {}: {}", name_of(failures[i].kind), failures[i].message);
  return text;
}

}  // namespace dccast::casting
