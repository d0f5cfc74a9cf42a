#include "server/jobs/queue/ledger.hpp"

#include <utility>

#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/stored_job.hpp"
#include "server/jobs/queue/queue_hold.hpp"

namespace dccast::jobs {

namespace {

void enter(JobRecord& record, v1::JobState to) {
  v1::Job& job = record.job;
  job.set_state(to);
  if (!is_terminal(to)) return;
  job.set_queue_position(0);
  if (!job.has_end_time()) *job.mutable_end_time() = now();
}

}  // namespace

void Ledger::write_event(JobRecord& record, const std::string& cause) {
  v1::Job& job = record.job;
  const auto log = logs_.open(job.id());
  log->take_over();
  log->complete(job);

  const bool terminal = is_terminal(job.state());
  if (const auto end = log->terminal_event(); terminal && end) {
    record.sequence = end->sequence();
    return;
  }

  v1::JobEvent event = state_event(record, cause);
  log->prepare(event);
  record.sequence = event.sequence();
  if (!terminal) return;

  // The end of a job is on the disk before anyone sees it.
  try {
    log->sync();
  } catch (...) {
    log->hand_over();  // takes the event back
    throw;
  }
}

void Ledger::write_store(const JobRecord& record, const std::string& cause, v1::JobState from) {
  const v1::Job& job = record.job;
  log::info("job {}: {} -> {}: {}", job.id(), v1::JobState_Name(from),
            v1::JobState_Name(job.state()), values::escaped(cause));
  for (const TransitionObserver& observer : transition_observers_) observer(job, from);

  index(record);
}

void Ledger::index(const JobRecord& record) {
  const std::string& id = record.job.id();

  try {
    store_.put(record);
    const std::lock_guard lock(mutex_);
    behind_.erase(id);
  } catch (const std::exception& error) {
    log::error("job {}: cannot update the store: {}; its folder is correct, and the store follows",
               id, error.what());
    const std::lock_guard lock(mutex_);
    behind_.insert(id);
    refusal_ = error.what();
    return;
  }

  report(record.job);
}

void Ledger::observe(JobObserver observer) {
  const std::lock_guard lock(observer_mutex_);
  observer_ = std::move(observer);
}

void Ledger::report(const v1::Job& job) {
  const std::lock_guard lock(observer_mutex_);
  if (observer_) observer_(job);
}

void Ledger::transition(JobRecord& record, v1::JobState to, const std::string& cause) {
  const v1::JobState from = record.job.state();
  JobRecord next = record;
  enter(next, to);
  write_event(next, cause);
  write_store(next, cause, from);
  record = std::move(next);
}

void Ledger::settle(JobRecord& record, v1::JobState to, const std::string& cause) {
  try {
    transition(record, to, cause);
  } catch (const std::exception& error) {
    log::error("job {}: cannot record the state {}: {}", record.job.id(), v1::JobState_Name(to),
               error.what());
    if (daemon_lacks(error)) throw;

    // The files of the job itself are damaged.
    fail_without_event(record, error.what());
  }
}

void Ledger::fail_without_event(JobRecord& record, const std::string& why) {
  const v1::JobState from = record.job.state();
  add_failure(record.job, v1::Finding::STORAGE, why);
  if (!is_terminal(from)) enter(record, v1::FAILED);
  write_store(record, why, from);
}

void Ledger::announce(const std::string& job_id) {
  try {
    logs_.open(job_id)->announce();
  } catch (const std::exception& error) {
    log::error("job {}: {}", job_id, error.what());  // damaged: settle() has logged it
  }
}

/// The record of a job whose row is behind; FAILED if its own files are damaged.
std::optional<JobRecord> Ledger::read_or_fail(const std::string& id) {
  try {
    return read_job(jobs_directory_ / id);
  } catch (const std::exception& error) {
    if (daemon_lacks(error)) throw;
    auto row = store_.find(id);
    if (!row) return std::nullopt;  // deleted meanwhile

    add_failure(row->job, v1::Finding::STORAGE, error.what());
    if (!is_terminal(row->job.state())) enter(*row, v1::FAILED);
    return row;
  }
}

void Ledger::retry() {
  std::set<std::string> behind;
  {
    const std::lock_guard lock(mutex_);
    behind = behind_;
  }

  for (const std::string& id : behind) {
    if (const auto record = read_or_fail(id)) {
      store_.put(*record);
      report(record->job);
    }
    const std::lock_guard lock(mutex_);
    behind_.erase(id);
  }
}

std::string Ledger::refusal() const {
  const std::lock_guard lock(mutex_);
  return behind_.empty() ? "" : refusal_;
}

std::optional<JobRecord> Ledger::find(const std::string& id) {
  auto row = store_.find(id);
  return row ? std::optional(present(std::move(*row))) : std::nullopt;
}

JobRecord Ledger::present(JobRecord row) {
  const std::string id = row.job.id();
  {
    const std::lock_guard lock(mutex_);
    if (!behind_.contains(id)) return row;
  }
  try {
    return read_job(jobs_directory_ / id);
  } catch (const std::exception& error) {
    log::error("job {}: {}", id, error.what());
    return row;
  }
}

}  // namespace dccast::jobs
