#include "server/jobs/ledger.hpp"

#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/storage_fault.hpp"

namespace dccast::jobs {

namespace {

void enter(JobRecord& record, v1::JobState to) {
  v1::Job& job = record.job;
  job.set_state(to);
  if (!is_terminal(to)) return;
  job.set_queue_position(0);
  if (!job.has_end_time()) *job.mutable_end_time() = timestamp(milliseconds(now()));
}

/// The files of the job itself are damaged: that is how it ends, unless it has ended before.
void note_damage(JobRecord& record, const std::string& why) {
  add_failure(record.job, v1::Failure::STORAGE, why);
  if (!is_terminal(record.job.state())) enter(record, v1::FAILED);
}

Durability durability_of(v1::JobState state) {
  return is_terminal(state) ? Durability::full : Durability::normal;
}

}  // namespace

void Ledger::write_event(JobRecord& record, const std::string& cause) {
  v1::Job& job = record.job;
  const auto log = logs_.open(job.id());
  log->tell(job);
  const bool terminal = is_terminal(job.state());
  if (!(terminal && log->terminal_event())) {
    v1::JobEvent event = state_event(job, cause);
    log->append(event);
  }
  // The event is on the disk before the store says so: a start after a crash finds the event at
  // least, and completes the store.
  if (terminal) log->sync();
}

void Ledger::write_store(const JobRecord& record, const std::string& cause, v1::JobState from) {
  const v1::Job& job = record.job;
  spdlog::info("job {}: {} -> {}: {}", job.id(), v1::JobState_Name(from),
               v1::JobState_Name(job.state()), cause);
  try {
    store_.update(record, durability_of(job.state()));
    pending_.erase(job.id());
  } catch (const std::exception& error) {
    spdlog::error("job {}: {}; its event log says what it is, the store follows", job.id(),
                  error.what());
    pending_[job.id()] = {record, cause, true};
    trouble_ = error.what();
  }
}

void Ledger::transition(JobRecord& record, v1::JobState to, const std::string& cause) {
  const v1::JobState from = record.job.state();
  JobRecord next = record;
  enter(next, to);
  write_event(next, cause);
  write_store(next, cause, from);
  record = std::move(next);
}

std::string Ledger::settle(JobRecord& record, v1::JobState to, const std::string& cause) {
  try {
    transition(record, to, cause);
    return {};
  } catch (const std::exception& error) {
    spdlog::error("job {}: cannot write that it is {}: {}", record.job.id(), v1::JobState_Name(to),
                  error.what());
    if (!daemon_lacks(error)) {
      fail_for_damage(record, error.what());
      return {};
    }
    enter(record, to);
    pending_[record.job.id()] = {record, cause, false};
    trouble_ = error.what();
    return error.what();
  }
}

void Ledger::fail_for_damage(JobRecord& record, const std::string& why) {
  const v1::JobState from = record.job.state();
  note_damage(record, why);
  write_store(record, why, from);
}

bool Ledger::write(Pending& pending) {
  try {
    if (!pending.event_written) write_event(pending.record, pending.cause);
    pending.event_written = true;
    store_.update(pending.record, durability_of(pending.record.job.state()));
    return true;
  } catch (const std::exception& error) {
    if (daemon_lacks(error) || pending.event_written) return false;  // said when it failed first
    spdlog::error("job {}: {}", pending.record.job.id(), error.what());
    note_damage(pending.record, error.what());
    pending.event_written = true;  // it never will be: its log is damaged
    return false;
  }
}

bool Ledger::retry() {
  for (auto at = pending_.begin(); at != pending_.end();)
    at = write(at->second) ? pending_.erase(at) : std::next(at);
  return pending_.empty();
}

std::optional<JobRecord> Ledger::find(const std::string& id) {
  if (const JobRecord* kept = pending(id)) return *kept;
  return store_.find(id);
}

const JobRecord* Ledger::pending(const std::string& id) const {
  const auto found = pending_.find(id);
  return found == pending_.end() ? nullptr : &found->second.record;
}

}  // namespace dccast::jobs
