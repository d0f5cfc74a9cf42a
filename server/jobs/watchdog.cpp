#include "server/jobs/watchdog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/jobs/worker_claim.hpp"

namespace dccast::jobs {

namespace {

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

void look_for_signs(Attempt& attempt, const std::filesystem::path& folder,
                    Attempt::Clock::time_point now) {
  attempt.looked = now;
  const auto sign = last_sign_of_life(folder);
  if (std::exchange(attempt.sign, sign) != sign) {
    if (!std::exchange(attempt.begun, true)) attempt.last_progress = now;
    attempt.last_sign = now;
  }
  const std::int64_t sequence = attempt.log->last_sequence();
  if (std::exchange(attempt.sequence, sequence) != sequence)
    attempt.last_sign = attempt.last_progress = now;
}

SilenceDeadline silence_deadline(const Attempt& attempt, const WatchdogLimits& limits) {
  if (!attempt.begun)
    return {attempt.last_sign + limits.hello,
            fmt::format("did not begin within {:g} s of its start", seconds(limits.hello))};
  const SilenceDeadline heartbeat{
      attempt.last_sign + limits.heartbeat,
      fmt::format("gave no sign of life for {:g} s", seconds(limits.heartbeat))};
  if (limits.stall.count() == 0) return heartbeat;
  const SilenceDeadline stall{
      attempt.last_progress + limits.stall,
      fmt::format("was alive but made no step for {:g} s", seconds(limits.stall))};
  return heartbeat.at <= stall.at ? heartbeat : stall;
}

Attempt::Clock::time_point next_look(const Attempt& attempt, const WatchdogLimits& limits) {
  auto shortest = std::min(limits.hello, limits.heartbeat);
  if (limits.stall.count() > 0) shortest = std::min(shortest, limits.stall);
  const auto interval = shortest / 4;
  return attempt.looked + std::max<std::chrono::milliseconds>(interval, std::chrono::milliseconds(1));
}

void forgive_silence(Attempt& attempt, Attempt::Clock::time_point now) {
  attempt.looked = attempt.last_sign = attempt.last_progress = now;
}

}  // namespace dccast::jobs
