#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "client/connection.hpp"
#include "client/job_watch.hpp"

namespace dccast::client {

/// Hands a study to `on_study` each time it has changed, until it has ended; returns it. A stream
/// that ends before is taken up again, as by follow_job. Throws CommandFailed, Interrupted.
v1::Study follow_study(Connection& connection, const std::string& id,
                       const std::function<void(const v1::Study&)>& on_study, std::ostream& talk,
                       const RetryPolicy& policy = {});

/// Exit code that a study's end means.
ExitCode exit_code_of(v1::StudyState state);

}  // namespace dccast::client
