#include "client/session/job_watch.hpp"

#include <algorithm>
#include <optional>
#include <ostream>

namespace dccast::client {
namespace {

/// One stream: reads until it ends. `next` is the sequence number that is due.
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
  // A stream that came to its own end keeps its status: cancelling it would hide a NOT_FOUND.
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
  for (int attempt = 0; attempt < policy.attempts;) {
    const Stream stream = read_stream(connection, id, next, on_event);
    if (stream.terminal) return *stream.terminal;
    if (connection.interruption().came()) throw Interrupted("");
    if (!is_passing(stream.status.error_code()))
      throw failure_of(stream.status, connection.server());
    attempt = stream.progressed ? 1 : attempt + 1;
    if (stream.progressed) pause = policy.first_pause;
    if (attempt == policy.attempts) break;
    messages << "watch: the stream from " << connection.server() << " ended"
             << (stream.status.ok() ? "" : " (" + reason_of(stream.status) + ")")
             << " but the job has not; taking it up again at event " << next << " (attempt "
             << attempt << " of " << policy.attempts - 1 << ")" << std::endl;
    connection.interruption().sleep(pause);
    pause = std::min(2 * pause, policy.longest_pause);
  }
  throw CommandFailed(ExitCode::unreachable,
                      "lost the stream of job " + id + " from " + connection.server() +
                          "; the job itself goes on. Take it up again: " + way_back(id, next));
}

}  // namespace

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
  switch (code) {
    case grpc::StatusCode::OK:
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::INTERNAL:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return true;
    default:
      return false;
  }
}

ExitCode exit_code_of(v1::JobState state) {
  return state == v1::SUCCEEDED ? ExitCode::done : ExitCode::solve_failed;
}

}  // namespace dccast::client
