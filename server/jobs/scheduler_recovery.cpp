// What the scheduler does once, before anything else: put in order what the last daemon left.
#include <spdlog/spdlog.h>

#include "server/jobs/events.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

namespace {

/// The log knows of an end that the store does not: the daemon died between the two.
void take_over_end(const v1::JobEvent& event, v1::Job& job) {
  if (event.state_change().has_failure()) *job.mutable_failure() = event.state_change().failure();
  *job.mutable_artifacts() = event.state_change().artifacts();
  *job.mutable_end_time() = timestamp(milliseconds(event.time()));
}

}  // namespace

void Scheduler::recover() {
  const std::lock_guard lock(mutex_);
  std::vector<JobRecord> unfinished = store_.unfinished();
  // All strays first: none of them may still write when anything of theirs is looked at.
  for (JobRecord& record : unfinished) {
    if (kill_stray(record.worker))
      spdlog::warn("job {}: killed a worker of the last daemon (process {})", record.job.id(),
                   record.worker.id);
    record.worker = {};
  }
  for (JobRecord& record : unfinished) {
    try {
      recover_job(record);
    } catch (const StoreError&) {
      throw;
    } catch (const std::exception& error) {
      auto* failure = record.job.mutable_failure();
      failure->set_kind(v1::Failure::STORAGE);
      failure->set_message(error.what());
      record.job.set_state(v1::FAILED);
      *record.job.mutable_end_time() = now();
      store_.update(record, Durability::full);
      spdlog::error("job {}: FAILED: {}", record.job.id(), error.what());
    }
  }
  quarantine_unknown_folders(options_.jobs_directory, store_.ids());
}

void Scheduler::recover_job(JobRecord record) {
  const std::string& id = record.job.id();
  const auto log = logs_.open(id);
  if (const auto end = log->terminal_event()) {
    take_over_end(*end, record.job);
    return transition(record, end->state_change().state(),
                      "ended just before the last daemon did: " + end->state_change().cause());
  }
  if (record.wish == Wish::cancel)
    return transition(record, v1::CANCELLED, "cancelled before dccastd was restarted");
  if (record.wish == Wish::pause) {
    record.wish = Wish::none;
    return transition(record, v1::PAUSED, "paused before dccastd was restarted");
  }
  if (record.job.state() == v1::RUNNING)
    transition(record, v1::QUEUED, "dccastd was restarted; goes on from its last checkpoint");
  if (record.job.state() == v1::QUEUED) queue_.push(record.job);
}

}  // namespace dccast::jobs
