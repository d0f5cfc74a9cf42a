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

/// A job with what the service does not publish of it.
struct JobRecord {
  v1::Job job;
  RequestedAction requested_action = RequestedAction::none;  ///< from its folder, not its row
  std::string request_reason{};                              ///< from its folder, not its row
  v1::JobEvent::WorkerLosses losses{};                       ///< deaths of its worker
  std::int64_t bytes = 0;     ///< case and attachments; after the end its whole folder [bytes]
  std::int64_t sequence = 0;  ///< of the event with its last state
  std::string answer_key{};   ///< digest of everything that determines its results, by
                              ///< case_file::fingerprint()
  std::string solver{};       ///< identity of the solver that succeeded; empty: none has
};

/// A case that has passed all checks, ready to become a job.
struct NewJob {
  JobDescription description;  ///< of its job what the submitter says; make_record() adds the rest
  std::string case_file{};     ///< as the submitter wrote it; empty: not known
  /// Starts at once, in addition to the jobs of the queue. A restarted daemon queues it normally.
  bool goes_first = false;
  /// It goes as far as its record (logs/readings_log.hpp), and starts beside the jobs of the queue.
  std::optional<v1::Following> following{};
};

/// Creates the first record of a job: queued, with a new id, created now.
JobRecord make_record(const NewJob& new_job, const Attachments& attachments);

/// The present time.
google::protobuf::Timestamp now();
/// Milliseconds since 1970, the unit of the store; 0 for an unset time.
std::int64_t milliseconds(const google::protobuf::Timestamp& time);
/// @param milliseconds  since 1970
google::protobuf::Timestamp timestamp(std::int64_t milliseconds);

/// Whether a job in this state has ended for good.
bool is_terminal(v1::JobState state);
/// Whether the end of a job is one that others wait for.
/// @param state  of the job that has ended; unspecified: it was deleted
bool ends_as_awaited(v1::JobState state, v1::AwaitedEnd end);

/// Adds a failure. The first one remains the cause; further ones are listed after it.
void add_failure(v1::Job& job, v1::Finding::Kind kind, const std::string& message);

/// Adds a finding, or replaces the one of the same code: the latest holds the worst exceedance.
void keep_finding(google::protobuf::RepeatedPtrField<v1::Finding>& findings,
                  const v1::Finding& finding);

/// An event with a note for people.
v1::JobEvent message_event(std::string text, v1::JobEvent::Message::Level level);

/// The event of a job that has entered its present state, from which its row can be made again.
/// @param record  with its new state, and failure and artifacts if it has ended
/// @param cause   one line for the user
v1::JobEvent state_event(const JobRecord& record, const std::string& cause);

}  // namespace dccast::jobs
