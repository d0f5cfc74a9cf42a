// Jobs that wait until others have succeeded.
#include "server/jobs/events.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

/// Into the queue, or beside it until the jobs before it have succeeded.
void Scheduler::enqueue(const v1::Job& job, bool goes_first) {
  if (job.after().empty()) return queue_.push(job, goes_first);
  dependents_[job.id()] = {job.after().begin(), job.after().end()};
  for (const std::string& before : job.after()) awaited_by_[before].insert(job.id());
  to_look_at_.insert(job.id());
}

void Scheduler::dequeue(const std::string& id) {
  queue_.erase(id);
  forget_dependent(id);
  look_at_those_after(id);
}

void Scheduler::forget_dependent(const std::string& id) {
  const auto found = dependents_.find(id);
  if (found == dependents_.end()) return;
  for (const std::string& before : found->second) {
    const auto awaited = awaited_by_.find(before);
    if (awaited == awaited_by_.end()) continue;  // named twice
    awaited->second.erase(id);
    if (awaited->second.empty()) awaited_by_.erase(awaited);
  }
  dependents_.erase(found);
  to_look_at_.erase(id);
}

/// A job has ended or was deleted.
void Scheduler::look_at_those_after(const std::string& id) {
  if (const auto found = awaited_by_.find(id); found != awaited_by_.end())
    to_look_at_.insert(found->second.begin(), found->second.end());
}

bool Scheduler::is_awaited(const std::string& id) {
  const std::lock_guard lock(mutex_);
  return awaited_by_.contains(id);
}

void Scheduler::settle_dependents() {
  for (;;) {
    std::string id;
    std::vector<std::string> after;
    {
      const std::lock_guard lock(mutex_);
      if (hold_.holds() || to_look_at_.empty()) return;
      id = *to_look_at_.begin();
      to_look_at_.erase(to_look_at_.begin());
      after = dependents_.at(id);
    }
    try {
      settle_dependent(id, after);
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      if (dependents_.contains(id)) to_look_at_.insert(id);
      return hold(error.what());
    }
  }
}

/// A job whose jobs before it have succeeded goes into the queue; one of which one has not, and
/// never will, is cancelled.
void Scheduler::settle_dependent(const std::string& id, const std::vector<std::string>& after) {
  std::string refusal;
  bool waits = false;
  for (const std::string& before : after) {
    const auto record = ledger_.find(before);
    const v1::JobState state = record ? record->job.state() : v1::JOB_STATE_UNSPECIFIED;
    if (state == v1::SUCCEEDED) continue;
    if (record && !is_terminal(state)) {
      waits = true;
      continue;
    }
    const char* how = !record                  ? "was deleted"
                      : state == v1::CANCELLED ? "was cancelled"
                                               : "has failed";
    refusal = "job " + before + ", which had to succeed first, " + how;
  }
  if (waits && refusal.empty()) return;
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, id);
  if (!dependents_.contains(id)) return;
  lock.unlock();
  auto record = ledger_.find(id);
  if (!record || record->job.state() != v1::QUEUED) return;
  if (!refusal.empty()) {
    settle_idle(lock, *record, v1::CANCELLED, refusal);
    return;
  }
  lock.lock();
  forget_dependent(id);
  queue_.push(record->job);
}

}  // namespace dccast::jobs
