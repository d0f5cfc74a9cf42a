#include "server/jobs/queue/job_requests.hpp"

#include <fmt/ranges.h>

#include <system_error>
#include <utility>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

Reply JobRequests::settle_idle(std::unique_lock<std::mutex>& lock, JobRecord& record,
                               v1::JobState to, const std::string& cause) {
  const std::string id = record.job.id();
  const auto folder = state_.jobs_directory / id;
  if (is_terminal(to)) record.bytes = bytes_kept(folder);

  state_.ledger.transition(record, to, cause);
  if (is_terminal(to)) remove_run_files(folder);
  const Lane lane = lane_in(folder);

  lock.lock();
  if (to == v1::QUEUED)
    state_.enqueue(record.job, lane);
  else
    state_.dequeue(id);
  state_.changed.notify_all();
  if (const std::string refusal = state_.ledger.refusal(); !refusal.empty()) state_.hold(refusal);
  Reply reply{Reply::Kind::done, views_.view(record)};
  lock.unlock();

  state_.ledger.announce(id);
  return reply;
}

Reply JobRequests::stop(const std::string& id, const Request& request) {
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, id);
  if (const auto attempt = state_.attempts.find(id)) return stop_worker(lock, *attempt, request);
  lock.unlock();

  auto record = state_.ledger.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  const v1::JobState state = record->job.state();
  const bool cancels = request.action == RequestedAction::cancel;
  if (is_terminal(state))
    return {cancels ? Reply::Kind::done : Reply::Kind::wrong_state, record->job};
  if (!cancels && state == v1::PAUSED) return {Reply::Kind::done, record->job};

  record->requested_action = request.action;
  record->request_reason = request.reason;
  const Settlement settlement = settle_stopped(*record, "");
  return settle_idle(lock, *record, settlement.state, settlement.cause);
}

/// The worker checks for a request after each step. It is killed if it does not stop in time.
Reply JobRequests::stop_worker(std::unique_lock<std::mutex>& lock, Attempt& attempt,
                               const Request& request) {
  if (attempt.record.requested_action >= request.action)
    return {Reply::Kind::done, views_.view(attempt)};

  lock.unlock();
  write_request(state_.jobs_directory / attempt.job_id, request);
  lock.lock();

  attempt.record.requested_action = request.action;
  attempt.record.request_reason = request.reason;
  state_.attempts.expect_stop(attempt);
  log::info("job {}: {} requested", attempt.job_id,
            request.action == RequestedAction::cancel ? "cancel" : "pause");
  state_.changed.notify_all();
  return {Reply::Kind::done, views_.view(attempt)};
}

Reply JobRequests::resume(const std::string& id) {
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, id);
  if (const auto attempt = state_.attempts.find(id))
    return {Reply::Kind::wrong_state, views_.view(*attempt)};
  lock.unlock();

  auto record = state_.ledger.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (record->job.state() != v1::PAUSED) return {Reply::Kind::wrong_state, record->job};

  record->requested_action = RequestedAction::none;
  return settle_idle(lock, *record, v1::QUEUED, "resumed by request");
}

Reply JobRequests::remove(const std::string& id, const std::string& why,
                          const std::function<bool(const v1::Job& job)>& permits) {
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, id);
  if (const auto attempt = state_.attempts.find(id)) {
    const bool cancelled = attempt->record.requested_action == RequestedAction::cancel;
    return {cancelled ? Reply::Kind::being_cancelled : Reply::Kind::wrong_state,
            views_.view(*attempt)};
  }
  lock.unlock();

  const auto record = state_.ledger.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  const bool may_be_removed =
      is_terminal(record->job.state()) && (!permits || permits(record->job));
  if (!may_be_removed) return {Reply::Kind::wrong_state, record->job};
  if (removal_observer_) removal_observer_(record->job);
  erase(*record);
  log::info("job {}: deleted, {}", id, why);

  lock.lock();
  state_.dependents.note_change(id);
  state_.changed.notify_all();
  return {Reply::Kind::done, {}};
}

/// Erases the row before the content of the folder, because deleting a large folder takes long and
/// without the row nothing refers to it.
void JobRequests::erase(const JobRecord& record) {
  const std::string& id = record.job.id();
  const auto removed = begin_removal(state_.jobs_directory, id);
  try {
    state_.store.erase(id);
  } catch (const StoreError&) {
    if (removed) undo_removal(*removed);
    throw;
  }

  std::error_code error;
  if (removed) std::filesystem::remove_all(*removed, error);
  if (error) log::warn("job {}: deleted, but part of its folder remains: {}", id, error.message());
  state_.ledger.report(record.job);
}

Reply JobRequests::mark(const std::string& id, const std::function<void(v1::Job& job)>& change) {
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob exclusive(state_, lock, id);
  lock.unlock();

  auto record = state_.ledger.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  v1::Job& job = record->job;
  change(job);

  write_marks(state_.jobs_directory / id, job);
  state_.ledger.index(*record);
  log::info("job {}: labels {}, {}, priority {}", id, fmt::join(job.labels(), ", "),
            job.pinned() ? "pinned" : "not pinned", v1::Priority_Name(job.priority()));

  lock.lock();
  state_.reorder(job);
  if (const auto attempt = state_.attempts.find(id)) {
    *attempt->record.job.mutable_labels() = job.labels();
    attempt->record.job.set_pinned(job.pinned());
  }
  return {Reply::Kind::done, views_.view(std::move(*record))};
}

}  // namespace dccast::jobs
