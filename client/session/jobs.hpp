#pragma once

#include <chrono>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client {

/// The id of the job that a user means: a complete id, a unique beginning of one, or `last` for the
/// newest job of this user that is no run of a study. Any other text is passed on for the server to
/// reject. Throws CommandFailed: no such job (not_found), or several (invalid), which the message
/// lists.
std::string resolve_job(Connection& connection, const std::string& text);
/// Whether a text is the beginning of an id, and no complete one.
bool can_begin_an_id(const std::string& text);
/// The user whose newest job or study `last` is: whom the server takes us for; where it does
/// not answer, the local user.
std::string user_name(Connection& connection);
/// resolve_job() for each text, in their order.
std::vector<std::string> resolve_jobs(Connection& connection,
                                      const std::vector<std::string>& texts);

/// The jobs that a command is about: those that are named, or one's own with all of these labels.
struct JobSelection {
  std::vector<std::string> jobs;  ///< as resolve_job() takes them
  std::vector<std::string> labels;
};
/// Their ids. Throws CommandFailed, also if both or neither are given.
/// @param states  of the jobs that labels select; empty: all
std::vector<std::string> selected_jobs(Connection& connection, const JobSelection& selection,
                                       const std::vector<v1::JobState>& states);

/// A time of the past, or one to come, as a user gives it (proto/values/times.hpp). Throws
/// CommandFailed.
std::int64_t seconds_of_past(const std::string& text);
std::int64_t seconds_to_come(const std::string& text);

/// Length of the shortest prefix, at least 8 characters, that distinguishes these ids.
std::size_t short_id_length(const std::vector<std::string>& ids);

/// Help text of a JOB argument.
inline constexpr const char* job_help = "Job id, the beginning of one, or last";

/// A list of jobs, and whether the server has more.
struct JobListing {
  /// Newest first, and whether the server has older ones.
  std::vector<v1::Job> jobs;
  bool more = false;
};
/// How the runs of a study count: each is a job like others, or they are one entry together.
enum class Runs { each, together };
/// Lists the jobs of a request, newest first, at most `limit` entries; reads all pages that are
/// needed. Throws CommandFailed, Interrupted.
/// @param request  its page size and token are set here
JobListing list_jobs(Connection& connection, v1::ListJobsRequest request, int limit,
                     Runs runs = Runs::each);

/// Whether the last stored frame is read, and how.
enum class LastFrame {
  left_out,
  computed,  ///< as it was computed
  drawn,     ///< with its skin, and liquid that stands level
};
/// Reads the whole history of a job, page by page, with the case and, on request, the last stored
/// frame. If the job is resumed from an earlier step meanwhile, the history is read again.
/// @return the status of the last call; `result` is complete if it is OK
grpc::Status try_query_result(Connection& connection, const std::string& id, LastFrame frame,
                              v1::QueryResultResponse& result);

/// The same without a frame. Throws CommandFailed for any status but OK.
v1::QueryResultResponse query_result(Connection& connection, const std::string& id);

/// Submits a job and repeats the call if the server is temporarily unavailable; the request id,
/// which must be set, makes this safe. Throws Interrupted. @return the status of the last attempt;
/// sets the job if it is OK
grpc::Status submit_with_retries(Connection& connection, const v1::SubmitJobRequest& request,
                                 v1::Job& job);

/// How often and how fast a broken stream is reconnected.
struct RetryPolicy {
  /// Consecutive attempts without an event before giving up; 0: it never does.
  int attempts = 12;
  std::chrono::milliseconds first_pause{200};
  /// Pauses double up to this one.
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
