#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/jobs/attempt.hpp"

namespace dccast::jobs {

/// How long a worker may be silent; from the settings of the daemon.
struct WatchdogLimits {
  std::chrono::milliseconds hello{30000};      ///< from its start to its first word
  std::chrono::milliseconds heartbeat{60000};  ///< between two words
  std::chrono::milliseconds stall{3600000};    ///< between two steps; 0: no limit
};

/// The first moment at which the worker of an attempt will have been silent for too long.
struct SilenceDeadline {
  Attempt::Clock::time_point at;
  std::string what;  ///< what it will not have done by then
};
SilenceDeadline silence_deadline(Attempt& attempt, const WatchdogLimits& limits);

/// Forgives a silence: the daemon itself stood still (a stopped process, a suspended machine), so
/// that nobody could be heard.
void forgive_silence(Attempt& attempt, Attempt::Clock::time_point now);

}  // namespace dccast::jobs
