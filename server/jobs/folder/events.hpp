#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/follow.pb.h"
#include "dccast/v1/job.pb.h"
#include "server/jobs/folder/job_folder.hpp"

/// The records of a job, and the events that its log holds.
namespace dccast::jobs {

/// A job with the fields that the service does not publish.
struct JobRecord {
  v1::Job job;
  RequestedAction requested_action = RequestedAction::none;  ///< from its folder, not its row
  std::string request_reason;                                ///< from its folder, not its row
  int losses = 0;                                            ///< number of deaths of its worker
  std::int64_t lost_step = -1;  ///< last step reported before the last loss; -1: never lost
  std::string first_loss;       ///< how the worker died the first time, the cause that is reported
  std::int64_t bytes = 0;       ///< case and attachments; after the end its whole folder [bytes]
  std::string answer_key{};     ///< digest of everything that determines its results, by
                                ///< case_file::fingerprint()
  std::string solver{};         ///< identity of the solver that succeeded; empty: none has
};

/// A case that has passed all checks, ready to become a job.
struct NewJob {
  std::string request_id;  ///< empty: none
  std::string study{};     ///< empty: none
  std::string title;
  v1::Priority priority = v1::NORMAL;
  std::string owner{};         ///< identity of the submitter
  std::string case_sha256;     ///< of the submitted case with its attachments
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::vector<std::string> labels{};
  std::vector<v1::CaseChange> changes{};  ///< already applied to the case
  std::string case_file{};                ///< as the submitter wrote it; empty: not known
  std::vector<std::string> after{};       ///< jobs that must succeed first
  double time_limit_s = 0.0;              ///< of wall time [s]; 0: no limit of its own
  std::string mail{};                     ///< address for the hook of the server; empty: none
  std::string quality{};                  ///< see Job
  double estimated_s = 0.0;               ///< run time estimated by the check [s]; 0: not known
  std::string answer_key{};               ///< see JobRecord
  /// Starts at once, in addition to the jobs of the queue. A restarted daemon queues it normally.
  bool goes_first = false;
  std::optional<v1::Following> following{};  ///< goes as far as its record (logs/readings_log.hpp)
};

/// Creates the first record of a job: queued, with a new id, created now.
JobRecord make_record(const NewJob& new_job, const Attachments& attachments);

/// The present time, to the millisecond.
google::protobuf::Timestamp now();
/// Milliseconds since 1970, the unit of the store; 0 for an unset time.
std::int64_t milliseconds(const google::protobuf::Timestamp& time);
/// @param milliseconds  since 1970
google::protobuf::Timestamp timestamp(std::int64_t milliseconds);

/// Whether a job in this state has ended for good.
bool is_terminal(v1::JobState state);

/// Adds a failure. The first one remains the cause; further ones are listed after it.
void add_failure(v1::Job& job, v1::Finding::Kind kind, const std::string& message);

/// Adds a finding, or replaces the one of the same code: the latest holds the worst exceedance.
void keep_finding(google::protobuf::RepeatedPtrField<v1::Finding>& findings,
                  const v1::Finding& finding);

/// An event with a note for people.
v1::JobEvent message_event(std::string text, v1::JobEvent::Message::Level level);

/// The event of a job that has entered its present state.
/// @param job    with its new state, and failure and artifacts if it has ended
/// @param cause  one line for the user
v1::JobEvent state_event(const v1::Job& job, const std::string& cause);
/// The same event with the losses and the solver, which the next daemon needs.
v1::JobEvent state_event(const JobRecord& record, const std::string& cause);

}  // namespace dccast::jobs
