#pragma once

#include <cstdint>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/job_store.hpp"

namespace dccast::jobs {

google::protobuf::Timestamp now();
/// Milliseconds since 1970, as the store keeps them; 0 for an unset time.
std::int64_t milliseconds(const google::protobuf::Timestamp& time);
google::protobuf::Timestamp timestamp(std::int64_t milliseconds);

bool is_terminal(v1::JobState state);

/// Adds what went wrong: the first cause stays, further ones are listed after it.
void add_failure(v1::Job& job, v1::Failure::Kind kind, const std::string& message);

/// Adds a finding, or replaces that of the same code: the last one has its worst exceedance.
void keep_finding(google::protobuf::RepeatedPtrField<v1::Finding>& findings,
                  const v1::Finding& finding);

v1::JobEvent message_event(std::string text, v1::JobEvent::Message::Level level);

/// The event of a job that has come into its present state.
/// @param job    with its new state, and failure and artifacts if it has ended
/// @param cause  why, one line for people
v1::JobEvent state_event(const v1::Job& job, const std::string& cause);
/// The same with what the next daemon needs to know of the attempts so far.
v1::JobEvent state_event(const JobRecord& record, const std::string& cause);

}  // namespace dccast::jobs
