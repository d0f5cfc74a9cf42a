#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "client/connection.hpp"
#include "client/job_watch.hpp"

namespace dccast::client {

/// Passes a study to `on_study` whenever it has changed, until it has ended; returns it. A stream
/// that ends before is reconnected as in follow_job. Throws CommandFailed, Interrupted.
v1::Study follow_study(Connection& connection, const std::string& id,
                       const std::function<void(const v1::Study&)>& on_study, std::ostream& talk,
                       const RetryPolicy& policy = {});

/// Exit code for the final state of a study.
ExitCode exit_code_of(v1::StudyState state);

}  // namespace dccast::client
