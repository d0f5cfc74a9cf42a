#include "server/jobs/queue/ledger.hpp"

#include <utility>

#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/queue/queue_hold.hpp"

namespace dccast::jobs {

namespace {

void enter(JobRecord& record, v1::JobState to) {
  v1::Job& job = record.job;
  job.set_state(to);
  if (!is_terminal(to)) return;
  job.set_queue_position(0);
  if (!job.has_end_time()) *job.mutable_end_time() = timestamp(milliseconds(now()));
}

Durability required_durability(v1::JobState state) {
  return is_terminal(state) ? Durability::full : Durability::normal;
}

}  // namespace

void Ledger::write_event(JobRecord& record, const std::string& cause) {
  v1::Job& job = record.job;
  const auto log = logs_.open(job.id());
  log->take_over();
  log->complete(job);

  const bool terminal = is_terminal(job.state());
  if (terminal && log->terminal_event()) return;

  v1::JobEvent event = state_event(record, cause);
  log->prepare(event);
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

  try {
    store_.update(record, required_durability(job.state()));
    const std::lock_guard lock(mutex_);
    kept_.erase(job.id());
  } catch (const std::exception& error) {
    log::error(
        "job {}: cannot update the store: {}; the event log is correct, and the store is "
        "updated later",
        job.id(), error.what());
    return keep(record, error.what());
  }
  report(job);
}

void Ledger::observe(JobObserver observer) {
  const std::lock_guard lock(observer_mutex_);
  observer_ = std::move(observer);
}

void Ledger::report(const v1::Job& job) {
  const std::lock_guard lock(observer_mutex_);
  if (observer_) observer_(job);
}

void Ledger::keep(const JobRecord& record, const std::string& why) {
  const std::lock_guard lock(mutex_);
  kept_[record.job.id()] = record;
  refusal_ = why;
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

    // The files of the job itself are damaged, so the job fails, unless it has ended before.
    const v1::JobState from = record.job.state();
    add_failure(record.job, v1::Finding::STORAGE, error.what());
    if (!is_terminal(from)) enter(record, v1::FAILED);
    write_store(record, error.what(), from);
  }
}

void Ledger::announce(const std::string& job_id) {
  try {
    logs_.open(job_id)->announce();
  } catch (const std::exception& error) {
    log::error("job {}: {}", job_id, error.what());  // damaged: settle() has logged it
  }
}

void Ledger::change_kept(const v1::Job& marks) {
  const std::lock_guard lock(mutex_);
  const auto found = kept_.find(marks.id());
  if (found == kept_.end()) return;
  *found->second.job.mutable_labels() = marks.labels();
  found->second.job.set_pinned(marks.pinned());
}

bool Ledger::retry() {
  std::map<std::string, JobRecord> kept;
  {
    const std::lock_guard lock(mutex_);
    kept = kept_;
  }

  for (const auto& [id, record] : kept) {
    try {
      store_.update(record, required_durability(record.job.state()));
    } catch (const std::exception&) {
      return false;  // logged at the first refusal
    }

    report(record.job);
    const std::lock_guard lock(mutex_);
    if (const auto found = kept_.find(id);
        found != kept_.end() && found->second.job.state() == record.job.state())
      kept_.erase(found);
  }

  const std::lock_guard lock(mutex_);
  return kept_.empty();
}

std::string Ledger::refusal() const {
  const std::lock_guard lock(mutex_);
  return kept_.empty() ? "" : refusal_;
}

std::optional<JobRecord> Ledger::find(const std::string& id) {
  if (auto record = kept(id)) return record;
  return store_.find(id);
}

std::optional<JobRecord> Ledger::kept(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = kept_.find(id);
  return found == kept_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace dccast::jobs
