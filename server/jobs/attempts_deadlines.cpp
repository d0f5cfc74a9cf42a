// Until when the workers of the attempts must have left, or said something.

#include <algorithm>

#include "server/jobs/attempts.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

void Attempts::kill_hung(Attempt& attempt, const std::string& what) {
  attempt.hung = what;
  attempt.kill_at = Clock::now() + last_words_time;  // tried again should the kill get lost
  spdlog::warn("job {}: its worker {}: killed", attempt.job_id, what);
  executor_.kill(attempt.job_id, attempt.number);
}

void Attempts::kill_overdue(Clock::time_point now) {
  std::vector<std::shared_ptr<Attempt>> overdue;
  for (const auto& [id, attempt] : attempts_) {
    if (attempt->kill_at && now >= *attempt->kill_at) overdue.push_back(attempt);
    if (attempt->settled || attempt->kill_at) continue;
    if (const auto silence = silence_deadline(*attempt, options_.watchdog); now >= silence.at)
      kill_hung(*attempt, silence.what);
  }
  for (const auto& attempt : overdue) {
    attempt->kill_at.reset();
    if (attempt->ended) {
      conclude(attempt, *attempt->ended);
      continue;
    }
    spdlog::warn("job {}: its worker did not leave in time: killed", attempt->job_id);
    executor_.kill(attempt->job_id, attempt->number);
  }
}

Attempts::Clock::time_point Attempts::next_deadline() const {
  Clock::time_point deadline = Clock::now() + std::chrono::hours(1);
  for (const auto& [id, attempt] : attempts_) {
    if (attempt->kill_at)
      deadline = std::min(deadline, *attempt->kill_at);
    else if (!attempt->settled)
      deadline = std::min(deadline, silence_deadline(*attempt, options_.watchdog).at);
  }
  return deadline;
}

void Attempts::forgive_silences(Clock::time_point now) {
  for (const auto& [id, attempt] : attempts_) jobs::forgive_silence(*attempt, now);
}

}  // namespace dccast::jobs
