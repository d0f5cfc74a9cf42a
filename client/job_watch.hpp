#pragma once

#include <chrono>
#include <functional>
#include <iosfwd>
#include <string>

#include "client/connection.hpp"

namespace dccast::client {

/// How often and how fast a dropped stream is taken up again.
struct RetryPolicy {
  int attempts = 12;  ///< in a row without an event; then the watch gives up
  std::chrono::milliseconds first_pause{200};
  std::chrono::milliseconds longest_pause{5000};
};

/// Hands every event of a job from `from_sequence` on to `on_event`, once and in order, until the
/// terminal one, which it returns. A stream that ends without it was cut: the watch says so on
/// `talk` and goes on after the last event it has. Throws CommandFailed when the server stays away
/// (unreachable; the job is not touched by that) or does not know the job, Interrupted with the
/// command to come back by.
v1::JobEvent::StateChange follow_job(Connection& connection, const std::string& id,
                                     std::int64_t from_sequence,
                                     const std::function<void(const v1::JobEvent&)>& on_event,
                                     std::ostream& talk, const RetryPolicy& policy = {});

/// Whether a stream that ended with this status can be taken up again.
bool is_passing(grpc::StatusCode code);

/// Exit code that a job's end means.
ExitCode exit_code_of(v1::JobState state);

}  // namespace dccast::client
