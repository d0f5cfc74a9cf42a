#include "client/level_attempts.hpp"

#include <charconv>
#include <optional>
#include <string_view>

namespace dccast::client {
namespace {

bool lost(const v1::Job& job) {
  return job.state() == v1::FAILED || job.state() == v1::CANCELLED;
}

/// Whether the same case would end in the same way again.
bool by_the_case_itself(const v1::Failure& failure) {
  switch (failure.kind()) {
    case v1::Failure::SOLVE_FAILED:
    case v1::Failure::CHECK_FAILED:
    case v1::Failure::INVALID_CASE:
    case v1::Failure::SHELL_MELTED_THROUGH:
    case v1::Failure::MOTION_TOO_LARGE:
    case v1::Failure::LIQUID_PRESSURE_LOST:
      return true;
    default:
      return false;
  }
}

/// The whole of `text` as a positive number.
std::optional<int> number_in(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < 1) return std::nullopt;
  return number;
}

/// Takes the job in if its request id is of the form.
void add(std::map<int, LevelAttempts>& levels, const std::string& prefix, const v1::Job& job) {
  if (!job.request_id().starts_with(prefix)) return;
  const std::string_view rest = std::string_view(job.request_id()).substr(prefix.size());
  const auto slash = rest.find('/');
  const auto refinement = number_in(rest.substr(0, slash));
  const auto attempt =
      slash == std::string_view::npos ? std::optional(1) : number_in(rest.substr(slash + 1));
  if (refinement && attempt) levels[*refinement].by_number[*attempt] = job;
}

}  // namespace

const v1::Job* LevelAttempts::current() const {
  if (by_number.empty()) return nullptr;
  for (auto attempt = by_number.rbegin(); attempt != by_number.rend(); ++attempt)
    if (!lost(attempt->second)) return &attempt->second;
  return &by_number.rbegin()->second;
}

bool LevelAttempts::can_be_repaired() const {
  const v1::Job* const job = current();
  return job != nullptr && lost(*job) && !by_the_case_itself(job->failure());
}

std::map<int, LevelAttempts> attempts_of(const std::string& study,
                                         const std::vector<v1::Job>& jobs) {
  std::map<int, LevelAttempts> levels;
  for (const v1::Job& job : jobs) add(levels, study + "/", job);
  return levels;
}

std::string attempt_request_id(const std::string& study, int refinement, int number) {
  const std::string first = study + "/" + std::to_string(refinement);
  return number == 1 ? first : first + "/" + std::to_string(number);
}

}  // namespace dccast::client
