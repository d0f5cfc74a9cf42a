#include "client/session/jobs.hpp"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <optional>
#include <ostream>
#include <set>

#include "dccast/v1/study.pb.h"
#include "proto/values/times.hpp"

namespace dccast::client {
namespace {

constexpr std::size_t id_length = 36;
constexpr std::size_t shortest = 8;
constexpr int most_candidates = 5;  // that are listed

std::string last_job(Connection& connection) {
  constexpr int most_looked_at = 5000;
  v1::ListJobsRequest request;
  request.set_owner(user_name(connection));
  const std::string owner = request.owner();

  // Reads pages, because runs of a study may be newer.
  for (int looked_at = 0; looked_at < most_looked_at;) {
    const auto found = connection.call(&Stub::ListJobs, request);
    for (const v1::Job& job : found.jobs())
      if (job.study().empty()) return job.id();
    looked_at += found.jobs_size();
    request.set_page_token(found.next_page_token());
    if (request.page_token().empty()) break;
  }

  throw CommandFailed(ExitCode::not_found,
                      "'last': no job on " + connection.server() + " belongs to " + owner +
                          ", besides runs of studies; name one by its id (dccast list)");
}

std::string ambiguous(const std::string& prefix, const v1::ListJobsResponse& found) {
  std::string text = "'" + prefix + "' is the beginning of more than one job:";
  for (int i = 0; i < std::min(most_candidates, found.jobs_size()); ++i)
    text += "\n  " + found.jobs(i).id() + "  " + found.jobs(i).title();
  if (found.jobs_size() > most_candidates) text += "\n  and more";
  return text;
}

/// Lists show studies among the jobs, so that a user may name one where a job is meant. Empty if
/// none begins so, or the server does not tell.
std::string if_a_study(Connection& connection, const std::string& prefix) {
  v1::ListStudiesRequest request;
  request.set_id_prefix(prefix);
  request.set_page_size(1);
  v1::ListStudiesResponse found;
  if (!connection.try_call(&Stub::ListStudies, request, found).ok()) return "";
  return found.studies().empty() ? "" : "; a study does: see dccast studies --help";
}

std::string job_that_begins(Connection& connection, const std::string& prefix) {
  v1::ListJobsRequest request;
  request.set_page_size(most_candidates + 1);
  request.set_id_prefix(prefix);
  const auto found = connection.call(&Stub::ListJobs, request);
  if (found.jobs().empty())
    throw CommandFailed(ExitCode::not_found, "no job on " + connection.server() + " begins with '" +
                                                 prefix + "' (dccast list)" +
                                                 if_a_study(connection, prefix));
  if (found.jobs_size() > 1) throw invalid(ambiguous(prefix, found));
  return found.jobs(0).id();
}

/// Reads all pages. Each page adds steps; case and frame come with the first.
grpc::Status read_pages(Connection& connection, v1::QueryResultRequest request,
                        v1::QueryResultResponse& result) {
  result.Clear();
  while (true) {
    v1::QueryResultResponse page;
    const grpc::Status status = connection.try_call(&Stub::QueryResult, request, page);
    if (!status.ok()) return status;
    result.MergeFrom(page);
    if (page.next_page_token().empty()) return status;
    if (page.next_page_token() == request.page_token())
      return {grpc::StatusCode::INTERNAL, "the server repeats a page of the history"};
    request.set_page_token(page.next_page_token());
  }
}

/// Reads one stream until it ends. `next` is the sequence number that is due.
struct Stream {
  std::optional<v1::JobEvent::StateChange> terminal;
  grpc::Status status;
  bool progressed = false;
};

Stream read_stream(Connection& connection, const std::string& id, std::int64_t& next,
                   const std::function<void(const v1::JobEvent&)>& on_event) {
  v1::WatchJobRequest request;
  request.set_id(id);
  request.set_from_sequence(next);

  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto reader = connection.stub().WatchJob(&context, request);

  Stream stream;
  v1::JobEvent event;
  while (!stream.terminal && reader->Read(&event)) {
    if (event.sequence() < next) continue;  // already received
    // Sequence numbers have no gaps: a missing event is requested again.
    if (event.sequence() > next) {
      context.TryCancel();
      break;
    }
    next = event.sequence() + 1;
    stream.progressed = true;
    on_event(event);
    if (event.has_state_change() && event.state_change().terminal())
      stream.terminal = event.state_change();
  }

  // A stream that has ended by itself keeps its status: cancelling it would hide a NOT_FOUND.
  if (stream.terminal) context.TryCancel();
  stream.status = reader->Finish();
  return stream;
}

std::string way_back(const std::string& id, std::int64_t next) {
  return "dccast watch --from " + std::to_string(next) + " " + id;
}

/// `next` is left at the sequence number that is due.
v1::JobEvent::StateChange follow(Connection& connection, const std::string& id, std::int64_t& next,
                                 const std::function<void(const v1::JobEvent&)>& on_event,
                                 std::ostream& messages, const RetryPolicy& policy) {
  auto pause = policy.first_pause;
  const bool gives_up = policy.attempts > 0;
  for (int attempt = 0; !gives_up || attempt < policy.attempts;) {
    const Stream stream = read_stream(connection, id, next, on_event);
    if (stream.terminal) return *stream.terminal;
    if (connection.interruption().came()) throw Interrupted("");
    if (!is_passing(stream.status.error_code()))
      throw failure_of(stream.status, connection.server());

    // A stream that brought events is sound: attempts count those in a row that brought none.
    attempt = stream.progressed ? 1 : attempt + 1;
    if (stream.progressed) pause = policy.first_pause;
    if (gives_up && attempt == policy.attempts) break;

    // Without an end one line is enough.
    if (gives_up || attempt == 1)
      messages << "watch: the stream from " << connection.server() << " ended"
               << (stream.status.ok() ? "" : " (" + reason_of(stream.status) + ")")
               << " but the job has not; taking it up again at event " << next
               << (gives_up ? fmt::format(" (attempt {} of {})", attempt, policy.attempts - 1) : "")
               << std::endl;
    connection.interruption().sleep(pause);
    pause = std::min(2 * pause, policy.longest_pause);
  }
  throw CommandFailed(ExitCode::unreachable,
                      "lost the stream of job " + id + " from " + connection.server() +
                          "; the job itself goes on. Take it up again: " + way_back(id, next));
}

}  // namespace

bool can_begin_an_id(const std::string& text) {
  return !text.empty() && text.size() < id_length &&
         text.find_first_not_of("0123456789abcdef-") == std::string::npos;
}

std::string user_name(Connection& connection) {
  v1::WhoAmIResponse who;
  if (connection.try_once(&Stub::WhoAmI, v1::WhoAmIRequest(), who).ok() && !who.name().empty())
    return who.name();
  const passwd* const user = ::getpwuid(::getuid());
  return user == nullptr ? "" : user->pw_name;
}

std::string resolve_job(Connection& connection, const std::string& text) {
  if (text == "last") return last_job(connection);
  if (can_begin_an_id(text)) return job_that_begins(connection, text);
  return text;
}

std::vector<std::string> resolve_jobs(Connection& connection,
                                      const std::vector<std::string>& texts) {
  std::vector<std::string> ids;
  for (const std::string& text : texts) ids.push_back(resolve_job(connection, text));
  return ids;
}

std::vector<std::string> selected_jobs(Connection& connection, const JobSelection& selection,
                                       const std::vector<v1::JobState>& states) {
  constexpr int most_jobs = 1'000'000;  // the most that a daemon keeps waiting
  if (selection.jobs.empty() == selection.labels.empty())
    throw invalid("give either JOBs or --label");
  if (!selection.jobs.empty()) return resolve_jobs(connection, selection.jobs);

  v1::ListJobsRequest request;
  request.set_owner(user_name(connection));
  request.mutable_labels()->Assign(selection.labels.begin(), selection.labels.end());
  request.mutable_states()->Assign(states.begin(), states.end());
  std::vector<std::string> ids;
  for (const v1::Job& job : list_jobs(connection, request, most_jobs).jobs) ids.push_back(job.id());
  return ids;
}

std::int64_t seconds_of_past(const std::string& text) {
  if (const auto time = values::past_time(text, std::time(nullptr))) return *time;
  throw invalid(fmt::format("'{}' is no time: {}", text, values::past_times));
}

std::int64_t seconds_to_come(const std::string& text) {
  if (const auto time = values::coming_time(text, std::time(nullptr))) return *time;
  throw invalid(fmt::format("'{}' is no time: {}", text, values::coming_times));
}

std::size_t short_id_length(const std::vector<std::string>& ids) {
  for (std::size_t length = shortest; length < id_length; ++length) {
    std::set<std::string> beginnings;
    for (const std::string& id : ids) beginnings.insert(id.substr(0, length));
    if (beginnings.size() == ids.size()) return length;
  }
  return id_length;
}

JobListing list_jobs(Connection& connection, v1::ListJobsRequest request, int limit, Runs runs) {
  constexpr int largest_page = 1000;  // service.proto
  JobListing listing;
  std::set<std::string> studies;
  int entries = 0;

  do {
    request.set_page_size(std::min(largest_page, limit - entries));
    const auto page = connection.call(&Stub::ListJobs, request);
    for (const v1::Job& job : page.jobs()) {
      listing.jobs.push_back(job);
      const bool is_known =
          runs == Runs::together && !job.study().empty() && !studies.insert(job.study()).second;
      if (!is_known) ++entries;
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty() && entries < limit);

  listing.more = !request.page_token().empty();
  return listing;
}

grpc::Status try_query_result(Connection& connection, const std::string& id, LastFrame frame,
                              v1::QueryResultResponse& result) {
  constexpr int readings = 5;  // a worker is restarted less often than that in one reading
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(frame != LastFrame::left_out);
  request.set_drawing(frame == LastFrame::drawn);

  grpc::Status status;
  for (int reading = 0; reading < readings; ++reading) {
    status = read_pages(connection, request, result);
    if (status.error_code() != grpc::StatusCode::ABORTED) break;
  }
  result.clear_next_page_token();
  return status;
}

v1::QueryResultResponse query_result(Connection& connection, const std::string& id) {
  v1::QueryResultResponse result;
  check(try_query_result(connection, id, LastFrame::left_out, result), connection.server());
  return result;
}

grpc::Status submit_with_retries(Connection& connection, const v1::SubmitJobRequest& request,
                                 v1::Job& job) {
  try {
    return connection.try_call(&Stub::SubmitJob, request, job);
  } catch (const Interrupted&) {
    throw Interrupted("the job may be in the queue already (dccast list)");
  }
}

v1::JobEvent::StateChange follow_job(Connection& connection, const std::string& id,
                                     std::int64_t from_sequence,
                                     const std::function<void(const v1::JobEvent&)>& on_event,
                                     std::ostream& messages, const RetryPolicy& policy) {
  std::int64_t next = std::max<std::int64_t>(from_sequence, 1);
  try {
    return follow(connection, id, next, on_event, messages, policy);
  } catch (const Interrupted&) {
    throw Interrupted("job " + id + " goes on. Come back: " + way_back(id, next));
  }
}

bool is_passing(grpc::StatusCode code) {
  constexpr std::array passing{grpc::OK,        grpc::UNAVAILABLE,       grpc::DEADLINE_EXCEEDED,
                               grpc::CANCELLED, grpc::ABORTED,           grpc::UNKNOWN,
                               grpc::INTERNAL,  grpc::RESOURCE_EXHAUSTED};
  return std::ranges::find(passing, code) != passing.end();
}

ExitCode exit_code_of(v1::JobState state) {
  return state == v1::SUCCEEDED ? ExitCode::done : ExitCode::solve_failed;
}

}  // namespace dccast::client
