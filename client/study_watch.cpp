#include "client/study_watch.hpp"

#include <algorithm>
#include <optional>
#include <ostream>

namespace dccast::client {
namespace {

/// One stream: reads until it ends.
struct Stream {
  std::optional<v1::Study> last;
  grpc::Status status;
};

Stream read_stream(Connection& connection, const std::string& id,
                   const std::function<void(const v1::Study&)>& on_study) {
  v1::WatchStudyRequest request;
  request.set_id(id);
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto reader = connection.stub().WatchStudy(&context, request);
  Stream stream;
  v1::Study study;
  while (reader->Read(&study)) {
    on_study(study);
    stream.last = study;
  }
  stream.status = reader->Finish();
  return stream;
}

bool ended(const Stream& stream) {
  return stream.status.ok() && stream.last && stream.last->state() != v1::STUDY_RUNNING;
}

}  // namespace

v1::Study follow_study(Connection& connection, const std::string& id,
                       const std::function<void(const v1::Study&)>& on_study, std::ostream& talk,
                       const RetryPolicy& policy) {
  auto pause = policy.first_pause;
  for (int attempt = 1; attempt < policy.attempts; ++attempt) {
    const Stream stream = read_stream(connection, id, on_study);
    if (ended(stream)) return *stream.last;
    if (connection.interruption().came()) throw Interrupted("");
    if (!is_passing(stream.status.error_code()))
      throw failure_of(stream.status, connection.server());
    if (stream.last) attempt = 1, pause = policy.first_pause;
    talk << "watch: the stream from " << connection.server()
         << " ended but the study has not; taking it up again (attempt " << attempt << " of "
         << policy.attempts - 1 << ")" << std::endl;
    connection.interruption().sleep(pause);
    pause = std::min(2 * pause, policy.longest_pause);
  }
  throw CommandFailed(ExitCode::unreachable, "lost the stream of study " + id + " from " +
                                                 connection.server() +
                                                 "; the study itself goes on");
}

ExitCode exit_code_of(v1::StudyState state) {
  return state == v1::STUDY_SUCCEEDED ? ExitCode::done : ExitCode::solve_failed;
}

}  // namespace dccast::client
