#pragma once

#include <chrono>
#include <functional>
#include <iosfwd>
#include <string>

#include "client/session/connection.hpp"

namespace dccast::client {

/// How often and how fast a broken stream is reconnected.
struct RetryPolicy {
  int attempts = 12;  ///< consecutive attempts without an event before giving up
  std::chrono::milliseconds first_pause{200};
  std::chrono::milliseconds longest_pause{5000};
};

/// Passes every event of a job from `from_sequence` on to `on_event`, once and in order, and
/// returns the terminal one. If the stream ends before, a message is written to `messages` and the
/// watch continues after the last event received. Throws CommandFailed if the server stays
/// unreachable (the job continues) or does not know the job, and Interrupted with the command that
/// continues the watch.
v1::JobEvent::StateChange follow_job(Connection& connection, const std::string& id,
                                     std::int64_t from_sequence,
                                     const std::function<void(const v1::JobEvent&)>& on_event,
                                     std::ostream& messages, const RetryPolicy& policy = {});

/// Whether a stream that ended with this status can be reconnected.
bool is_passing(grpc::StatusCode code);

/// Exit code for the final state of a job.
ExitCode exit_code_of(v1::JobState state);

}  // namespace dccast::client
