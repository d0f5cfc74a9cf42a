#include "server/worker/run_job.hpp"

#include <filesystem>
#include <system_error>

#include "core/casting/simulation.hpp"
#include "proto/values/sha256.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/translate/case_to_core.hpp"
#include "server/translate/faults_to_proto.hpp"
#include "server/translate/step_to_proto.hpp"
#include "server/worker/reporting_observer.hpp"

namespace dccast::worker {

namespace {

namespace fs = std::filesystem;
using Finished = v1::WorkerMessage::Finished;

Finished failed(v1::Failure::Kind kind, const std::string& message) {
  Finished finished;
  finished.set_outcome(Finished::FAILED);
  finished.mutable_failure()->set_kind(kind);
  finished.mutable_failure()->set_message(message);
  return finished;
}

/// What the run left, with sizes and checksums: computed once, here, while the files are still in
/// the page cache and the daemon has better things to do.
void add_artifacts(const fs::path& directory, Finished& finished) {
  for (const char* name : {"results.h5", "results.xdmf"}) {
    if (!fs::exists(directory / name)) continue;
    auto* artifact = finished.add_artifacts();
    artifact->set_name(name);
    artifact->set_size_bytes(static_cast<std::int64_t>(fs::file_size(directory / name)));
    artifact->set_sha256(values::sha256_of_file(directory / name));
  }
}

Finished with_failure(const casting::RunOutcome& outcome, v1::Failure::Kind kind) {
  Finished finished;
  finished.set_outcome(Finished::FAILED);
  *finished.mutable_failure() =
      translate::to_proto(outcome.failure.value_or(casting::RunFailure{}), kind);
  return finished;
}

Finished to_finished(const casting::RunOutcome& outcome) {
  Finished finished;
  switch (outcome.end) {
    case casting::RunEnd::succeeded:
      finished.set_outcome(Finished::SUCCEEDED);
      break;
    case casting::RunEnd::stopped:
      finished.set_outcome(Finished::STOPPED);
      break;
    case casting::RunEnd::cancelled:
      finished.set_outcome(Finished::CANCELLED);
      break;
    case casting::RunEnd::solve_failed:
      return with_failure(outcome, v1::Failure::SOLVE_FAILED);
    case casting::RunEnd::check_failed:
      return with_failure(outcome, v1::Failure::CHECK_FAILED);
  }
  return finished;
}

Finished run(const v1::WorkerOrder::Start& start, LinkClient& link) {
  const fs::path directory = start.directory();
  const auto casting_case = translate::to_core(start.case_(), directory / jobs::attachments_folder);
  ReportingObserver observer(link, casting_case.monitors);
  const auto outcome =
      casting::run(casting_case, {.path = directory, .resume = start.resume()}, observer);
  Finished finished = to_finished(outcome);
  if (outcome.end == casting::RunEnd::succeeded || outcome.end == casting::RunEnd::check_failed ||
      outcome.end == casting::RunEnd::solve_failed)
    add_artifacts(directory, finished);
  return finished;
}

}  // namespace

Finished run_job(const v1::WorkerOrder::Start& start, LinkClient& link) {
  try {
    return run(start, link);
  } catch (const InvalidCase& error) {
    return failed(v1::Failure::INVALID_CASE, translate::in_words(error.faults()));
  } catch (const std::system_error& error) {
    return failed(v1::Failure::STORAGE, error.what());
  } catch (const std::exception& error) {
    return failed(v1::Failure::INTERNAL, error.what());
  }
}

}  // namespace dccast::worker
