#include "server/jobs/watchdog.hpp"

#include <fmt/format.h>

namespace dccast::jobs {

namespace {

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

SilenceDeadline silence_deadline(Attempt& attempt, const WatchdogLimits& limits) {
  const std::lock_guard lock(attempt.mutex);
  if (!attempt.channel)
    return {attempt.begun + limits.hello,
            fmt::format("did not call within {:g} s of {}", seconds(limits.hello),
                        attempt.adopted ? "the restart of dccastd" : "its start")};
  const SilenceDeadline heartbeat{
      attempt.last_word + limits.heartbeat,
      fmt::format("gave no sign of life for {:g} s", seconds(limits.heartbeat))};
  if (limits.stall.count() == 0) return heartbeat;
  const SilenceDeadline stall{
      attempt.last_advance + limits.stall,
      fmt::format("was alive but made no step for {:g} s", seconds(limits.stall))};
  return heartbeat.at <= stall.at ? heartbeat : stall;
}

void forgive_silence(Attempt& attempt, Attempt::Clock::time_point now) {
  const std::lock_guard lock(attempt.mutex);
  attempt.begun = attempt.last_word = attempt.last_advance = now;
}

}  // namespace dccast::jobs
