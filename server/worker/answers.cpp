#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>

#include "core/case/case_check.hpp"
#include "core/casting/simulation.hpp"
#include "core/casting/stored_run.hpp"
#include "core/findings/judge.hpp"
#include "core/results/result_reader.hpp"
#include "core/results/study_table.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/translate/case_to_core.hpp"
#include "server/translate/to_proto.hpp"
#include "server/worker/main.hpp"
#include "server/worker/run_job.hpp"

namespace dccast::worker {

namespace {

/// A run without a job: every event goes to the daemon. Who wants no more of it kills this process.
///
/// A message wakes the daemon, which costs the solver's core more than the message itself. Steps
/// that follow each other quickly are therefore sent together.
class EventsToDaemon : public RunLink {
public:
  explicit EventsToDaemon(int socket) : stream_(socket) {}
  void send(v1::JobEvent event) override {
    const bool may_wait = event.has_step() && Clock::now() - sent_ < together;
    v1::WorkerAnswer answer;
    *answer.mutable_event() = std::move(event);
    const bool written =
        google::protobuf::util::SerializeDelimitedToZeroCopyStream(answer, &stream_);
    if (!written || !(may_wait || stream_.Flush())) ::_exit(exit_link_broken);
    if (!may_wait) sent_ = Clock::now();
  }
  casting::Order order() const override { return casting::Order::go_on; }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds together{5};

  google::protobuf::io::FileOutputStream stream_;  ///< sends what waits when it is destroyed
  Clock::time_point sent_{};
};

/// The verdict on a case; where it is asked for with findings: whether a case that can be run is
/// one that a plant could run.
v1::ValidateCaseResponse verdict_on(const v1::CheckCase& asked) {
  const std::filesystem::path folder = asked.directory();
  const casting::Case c = translate::to_core(asked.case_(), folder / jobs::attachments_folder);
  v1::ValidateCaseResponse verdict = translate::to_proto(
      casting::check(c, {asked.faulty_keys().begin(), asked.faulty_keys().end()}));
  if (!asked.findings() || verdict.faults_size() > 0 || asked.faulty_keys_size() > 0)
    return verdict;
  for (const auto& found : {casting::findings_of_case(c), casting::forecast(c)})
    for (const results::Finding& finding : found)
      *verdict.add_findings() = translate::to_proto(finding);
  return verdict;
}

v1::QueryResultResponse stored_frame(const v1::ReadFrame& asked) {
  const results::ResultReader reader(std::filesystem::path(asked.directory()) / "results.h5");
  v1::QueryResultResponse found;
  const auto times = reader.frame_times();
  found.mutable_frame_time_s()->Add(times.begin(), times.end());
  const auto number = asked.number() == 0 ? times.size() : static_cast<std::size_t>(asked.number());
  if (number >= 1 && number <= times.size())
    *found.mutable_frame() = translate::to_proto(reader.frame(number - 1), reader.header());
  return found;
}

void fill(v1::WorkerAnswer& answer, const v1::WorkerRequest& request, int socket) {
  switch (request.request_case()) {
    case v1::WorkerRequest::kCheck:
      *answer.mutable_verdict() = verdict_on(request.check());
      return;
    case v1::WorkerRequest::kReadFrame:
      *answer.mutable_stored() = stored_frame(request.read_frame());
      return;
    case v1::WorkerRequest::kWriteTable:
      return results::write_study_table(request.write_table().path(),
                                        translate::to_table(request.write_table().study()));
    case v1::WorkerRequest::kSolve: {
      EventsToDaemon events(socket);
      *answer.mutable_run_end() = run_job(request.solve(), events);
      return;
    }
    case v1::WorkerRequest::kNameSolver:
      return answer.set_solver(casting::solver_identity());
    case v1::WorkerRequest::REQUEST_NOT_SET:
      throw std::runtime_error("there is no such request");
  }
}

}  // namespace

bool send_answer(int socket, const v1::WorkerAnswer& answer) {
  return google::protobuf::util::SerializeDelimitedToFileDescriptor(answer, socket);
}

v1::WorkerAnswer answer(const v1::WorkerRequest& request, int socket) {
  v1::WorkerAnswer answered;
  try {
    fill(answered, request, socket);
  } catch (const std::exception& error) {
    answered.set_refused(error.what());
  }
  return answered;
}

}  // namespace dccast::worker
