#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/folder/job_folder.hpp"

/// What is known of a job, and the messages of its life.
namespace dccast::jobs {

/// A job with what the service keeps to itself.
struct JobRecord {
  v1::Job job;
  RequestedAction requested_action = RequestedAction::none;  ///< of its folder, not of its row
  std::string request_reason;                                ///< the same
  int losses = 0;                                            ///< times its worker died
  std::int64_t lost_step = -1;  ///< last step reported before the last loss; -1: never lost
  std::string first_loss;       ///< how the worker died the first time: the cause that is kept
  std::int64_t bytes = 0;       ///< of the case and its attachments; once ended of its folder
  std::string answer_key{};     ///< of all that decides its figures: intake::answer_key()
  std::string solver{};         ///< identity of the solver that succeeded with it; empty: none has
};

/// A case that was found good, ready to become a job.
struct NewJob {
  std::string request_id;  ///< empty: none
  std::string study{};     ///< empty: none
  std::string title;
  v1::Priority priority = v1::NORMAL;
  std::string owner{};         ///< who submits it
  std::string case_sha256;     ///< of the case as it was submitted, with its attachments
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::vector<std::string> labels{};
  std::vector<v1::CaseChange> changes{};  ///< made in the case already
  std::string case_file{};                ///< as the submitter wrote it; empty: not known
  std::vector<std::string> after{};       ///< jobs that must succeed first
  double time_limit_s = 0.0;              ///< of wall time; 0: none of its own
  std::string mail{};                     ///< for the hook of the server; empty: none
  double estimated_s = 0.0;               ///< what the check took the run for; 0: not known
  std::string answer_key{};               ///< see JobRecord
  /// It starts at once, beside the others, as long as this daemon serves; else as they do.
  bool goes_first = false;
};

/// The job as it is stored first: with an id of its own, queued, created now.
JobRecord record_of_new(const NewJob& new_job, const Attachments& attachments);

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
