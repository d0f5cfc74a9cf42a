#include "server/jobs/queue/settlement.hpp"

#include <cmath>
#include <utility>

#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

namespace {

using v1::RunEnd;

/// Attempts in a row that may end because something was not written, without getting any further.
/// The queue was held between them until the daemon could write: it is this job that cannot.
constexpr int most_storage_failures = 10;

/// Something could not be written. The queue is held for that as long as it may pass.
Settlement settle_for_storage(JobRecord& record, const std::string& error,
                              const AttemptFacts& facts) {
  if (facts.storage_failures >= most_storage_failures) {
    add_failure(record.job, v1::Failure::STORAGE, error);
    return {v1::FAILED, error};
  }
  Settlement settlement = settle_stopped(record, error + "; goes on once writing works again");
  settlement.daemon_lacks = error;
  return settlement;
}

Settlement settle_succeeded(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  *record.job.mutable_artifacts() = end.artifacts();
  if (facts.missing_artifact.empty()) return {v1::SUCCEEDED, "finished"};
  add_failure(record.job, v1::Failure::STORAGE, facts.missing_artifact);
  return {v1::FAILED, facts.missing_artifact};
}

/// What the worker could not write, whatever else went wrong before; empty when it wrote all.
std::string unwritten(const v1::Failure& failure) {
  if (failure.kind() == v1::Failure::STORAGE) return failure.message();
  for (const std::string& further : failure.further_causes())
    if (further.starts_with("STORAGE: ")) return further.substr(further.find(' ') + 1);
  return {};
}

Settlement settle_failed(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  const v1::Failure& failure = end.failure();
  // The run comes to the same end once its results can be written.
  if (const std::string error = unwritten(failure);
      !error.empty() && facts.storage_failures < most_storage_failures)
    return settle_for_storage(record, error, facts);
  *record.job.mutable_failure() = failure;
  *record.job.mutable_artifacts() = end.artifacts();
  return {v1::FAILED, failure.message()};
}

Settlement settle_other_version(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  const std::string& reason = end.failure().message();
  if (facts.other_version == v1::FAIL) {
    *record.job.mutable_failure() = end.failure();
    return {v1::FAILED, reason};
  }
  record.requested_action = RequestedAction::none;
  return {v1::PAUSED, reason + "; resuming it starts the run over"};
}

/// Whether it was stopped for its time limit alone.
bool is_over_time(const JobRecord& record, const AttemptFacts& facts) {
  return !facts.over_time.empty() && record.requested_action != RequestedAction::cancel;
}

Settlement settle_over_time(JobRecord& record, const AttemptFacts& facts) {
  const std::string message =
      facts.over_time + " and has reached its time limit at " +
      std::to_string(std::lround(100.0 * record.job.last_step().progress())) +
      " % of the casting; submit it again with a longer one (dccast submit --from " +
      record.job.id() + " --time-limit), with a coarser quality or a shorter time.end";
  add_failure(record.job, v1::Failure::TIME_LIMIT, message);
  record.job.mutable_failure()->set_time_s(facts.reached_time);
  return {v1::FAILED, message};
}

std::string times_died(const JobRecord& record, bool same_step, std::int64_t step) {
  std::string message = record.first_loss;
  if (record.losses > 1) message += "; in all it died " + std::to_string(record.losses) + " times";
  if (same_step) message += ", twice in the step after " + std::to_string(step);
  return message;
}

}  // namespace

Settlement settle_stopped(JobRecord& record, const std::string& cause) {
  const RequestedAction requested = std::exchange(record.requested_action, RequestedAction::none);
  if (requested == RequestedAction::cancel)
    return {v1::CANCELLED, record.request_reason.empty() ? "cancelled by request"
                                                         : "cancelled: " + record.request_reason};
  if (requested == RequestedAction::pause) return {v1::PAUSED, "paused by request"};
  return {v1::QUEUED, cause};
}

Settlement settle_run_end(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  switch (end.outcome()) {
    case RunEnd::SUCCEEDED:
      return settle_succeeded(record, end, facts);
    case RunEnd::FAILED:
      return settle_failed(record, end, facts);
    case RunEnd::OTHER_VERSION_FOUND:
      return settle_other_version(record, end, facts);
    default:
      if (is_over_time(record, facts)) return settle_over_time(record, facts);
      return settle_stopped(record, facts.shutting_down
                                        ? "dccastd is shutting down; stopped at a checkpoint"
                                        : "its worker was asked to stop; stopped at a checkpoint");
  }
}

Settlement settle_lost(JobRecord& record, const WorkerExit& exit, const AttemptFacts& facts) {
  if (!facts.storage_error.empty()) return settle_for_storage(record, facts.storage_error, facts);
  if (is_over_time(record, facts)) return settle_over_time(record, facts);
  if (record.requested_action != RequestedAction::none || facts.shutting_down)
    return settle_stopped(record, "dccastd is shutting down; its worker was killed");
  if (exit.of_machine)
    return settle_stopped(record, exit.how + "; goes on from its last checkpoint");
  if (exit.code == exit_out_of_memory) {
    add_failure(record.job, v1::Failure::OUT_OF_MEMORY, out_of_memory_text);
    return {v1::FAILED, out_of_memory_text};
  }
  const std::string loss =
      "worker " + (facts.hung.empty() ? "died with " + exit.how : facts.hung + " and was killed") +
      " after step " + std::to_string(facts.reached_step);
  if (record.losses++ == 0) record.first_loss = loss;
  const bool same_step = record.lost_step == facts.reached_step;
  record.lost_step = facts.reached_step;
  if (record.losses <= facts.worker_restarts)
    return {v1::QUEUED, loss + "; restart " + std::to_string(record.losses) + " of " +
                            std::to_string(facts.worker_restarts)};
  const std::string message = times_died(record, same_step, facts.reached_step);
  add_failure(record.job, facts.hung.empty() ? v1::Failure::WORKER_LOST : v1::Failure::WORKER_HUNG,
              message);
  record.job.mutable_failure()->set_time_s(facts.reached_time);
  return {v1::FAILED, message};
}

}  // namespace dccast::jobs
