#include "server/jobs/queue/settlement.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"

namespace dccast::jobs {

namespace {

using v1::RunEnd;

/// Largest number of consecutive attempts that a failed write may end without progress. The queue
/// was held between them until the daemon could write, so the fault concerns this job alone.
constexpr int largest_storage_failures = 10;

/// A write failed. The queue is held while the fault may pass.
Settlement settle_for_storage(JobRecord& record, const std::string& error,
                              const AttemptFacts& facts) {
  if (facts.storage_failures >= largest_storage_failures) {
    add_failure(record.job, v1::Finding::STORAGE, error);
    return {v1::FAILED, error};
  }
  Settlement settlement =
      settle_stopped(record, fmt::format("{}; goes on once writing works again", error));
  settlement.daemon_lacks = error;
  return settlement;
}

Settlement settle_succeeded(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  *record.job.mutable_artifacts() = end.artifacts();
  if (facts.missing_artifact.empty()) return {v1::SUCCEEDED, "finished"};
  add_failure(record.job, v1::Finding::STORAGE, facts.missing_artifact);
  return {v1::FAILED, facts.missing_artifact};
}

/// The error of a failed write, which may follow another failure; empty if all was written.
std::string find_write_error(const v1::Finding& failure) {
  if (failure.kind() == v1::Finding::STORAGE) return failure.message();
  for (const v1::Finding& further : failure.further())
    if (further.kind() == v1::Finding::STORAGE) return further.message();
  return {};
}

/// Fails a job for its own files: they will not be sound at another try.
Settlement settle_damaged(JobRecord& record, const std::string& damage) {
  const std::string message = fmt::format(
      "the folder of the job is damaged: {}; restore it from a backup, or submit the case again",
      damage);
  add_failure(record.job, v1::Finding::STORAGE, message);
  return {v1::FAILED, message};
}

Settlement settle_failed(JobRecord& record, const RunEnd& end, const AttemptFacts& facts) {
  if (!facts.damage.empty()) return settle_damaged(record, facts.damage);
  const v1::Finding& failure = end.failure();
  // Run again when its results can be written: it will end in the same way.
  if (const std::string error = find_write_error(failure);
      !error.empty() && facts.storage_failures < largest_storage_failures)
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
  return {v1::PAUSED, fmt::format("{}; resuming it starts the run over", reason)};
}

/// Whether it was stopped for a limit of time and not cancelled as well.
bool is_over_time(const JobRecord& record, const AttemptFacts& facts) {
  const bool was_stopped = !facts.over_time.empty() || !facts.unfed.empty();
  return was_stopped && record.requested_action != RequestedAction::cancel;
}

Settlement settle_over_time(JobRecord& record, const AttemptFacts& facts) {
  const long percent = std::lround(100.0 * record.job.last_step().progress());
  const std::string message =
      facts.unfed.empty()
          ? fmt::format(
                "{} and has reached its time limit at {} % of the casting; submit it again "
                "with a longer one (dccast submit --from {} --time-limit), with a coarser "
                "quality or a shorter time.end",
                facts.over_time, percent, record.job.id())
          : fmt::format(
                "{}, at {} % of the casting; follow it again once its source sends readings, "
                "or have workers.stall_timeout raised in the settings of dccastd",
                facts.unfed, percent);

  add_failure(record.job, v1::Finding::TIME_LIMIT, message);
  record.job.mutable_failure()->set_time_s(facts.reached_time);
  return {v1::FAILED, message};
}

/// Describes the deaths of a worker: the first and the last one.
/// @param last       "worker died with signal 11 after step 7"
/// @param same_step  the one before it was in the same step
std::string describe_losses(const JobRecord& record, const std::string& last, bool same_step) {
  const int times = record.losses.times();
  if (times == 1) return last;
  // Twice in one step points to the case rather than to the machine.
  const std::string end = same_step
                              ? fmt::format("twice in the step after {}", record.losses.last_step())
                              : fmt::format("at last: {}", last);
  return fmt::format("{}; in all it died {} times, {}", record.losses.first_cause(), times, end);
}

}  // namespace

Settlement settle_stopped(JobRecord& record, const std::string& cause) {
  const RequestedAction requested = std::exchange(record.requested_action, RequestedAction::none);
  if (requested == RequestedAction::cancel && record.request_reason.empty())
    return {v1::CANCELLED, "cancelled by request"};
  if (requested == RequestedAction::cancel)
    return {v1::CANCELLED, fmt::format("cancelled: {}", record.request_reason)};
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
  if (!facts.damage.empty()) return settle_damaged(record, facts.damage);
  if (!facts.storage_error.empty()) return settle_for_storage(record, facts.storage_error, facts);
  if (is_over_time(record, facts)) return settle_over_time(record, facts);
  if (record.requested_action != RequestedAction::none || facts.shutting_down)
    return settle_stopped(record, "dccastd is shutting down; its worker was killed");
  if (exit.cancelled) return {v1::CANCELLED, "cancelled in Slurm, not by dccast"};
  if (exit.of_machine)
    return settle_stopped(record, fmt::format("{}; goes on from its last checkpoint", exit.how));
  if (exit.code == exit_out_of_memory) {
    add_failure(record.job, v1::Finding::OUT_OF_MEMORY, out_of_memory_text);
    return {v1::FAILED, out_of_memory_text};
  }

  const std::string end = facts.hung.empty() ? fmt::format("died with {}", exit.how)
                                             : fmt::format("{} and was killed", facts.hung);
  const std::string loss = fmt::format("worker {} after step {}", end, facts.reached_step);
  v1::JobEvent::WorkerLosses& losses = record.losses;
  const bool same_step = losses.times() > 0 && losses.last_step() == facts.reached_step;
  if (losses.times() == 0) losses.set_first_cause(loss);
  losses.set_times(losses.times() + 1);
  losses.set_last_step(facts.reached_step);
  if (losses.times() <= facts.worker_restarts)
    return {v1::QUEUED,
            fmt::format("{}; restart {} of {}", loss, losses.times(), facts.worker_restarts)};

  const std::string message = describe_losses(record, loss, same_step);
  add_failure(record.job, facts.hung.empty() ? v1::Finding::WORKER_LOST : v1::Finding::WORKER_HUNG,
              message);
  record.job.mutable_failure()->set_time_s(facts.reached_time);
  return {v1::FAILED, message};
}

}  // namespace dccast::jobs
