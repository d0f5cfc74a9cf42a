#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "server/jobs/attempt.hpp"

namespace dccast::jobs {

/// How long a worker may be silent; from the settings of the daemon.
struct WatchdogLimits {
  std::chrono::milliseconds hello{30000};      ///< from its start to its claim on the folder
  std::chrono::milliseconds heartbeat{60000};  ///< between two signs of life
  std::chrono::milliseconds stall{3600000};    ///< between two events; 0: no limit
};

/// Looks for new signs of life: the time of the claim on the folder, the events of the log.
void look_for_signs(Attempt& attempt, const std::filesystem::path& folder,
                    Attempt::Clock::time_point now);

/// The first moment at which the worker of an attempt will have been silent for too long.
struct SilenceDeadline {
  Attempt::Clock::time_point at;
  std::string what;  ///< what it will not have done by then
};
SilenceDeadline silence_deadline(const Attempt& attempt, const WatchdogLimits& limits);

/// When to look for signs again.
Attempt::Clock::time_point next_look(const Attempt& attempt, const WatchdogLimits& limits);

/// Begins to count anew: the daemon itself stood still (a stopped process, a suspended machine) and
/// has seen no signs.
void forgive_silence(Attempt& attempt, Attempt::Clock::time_point now);

}  // namespace dccast::jobs
