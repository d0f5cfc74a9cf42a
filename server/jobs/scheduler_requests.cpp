// What clients ask of the scheduler: submit, look, cancel, pause, resume, delete.

#include <system_error>
#include <utility>

#include "core/storage/durable_file.hpp"
#include "proto/values/uuid.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/free_space.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/new_job.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

namespace {

/// A job that was to join a study must not be answered with one outside of it.
void require_same_submission(const v1::Job& there, const NewJob& new_job) {
  const bool same_case = there.case_sha256() == new_job.case_sha256;
  if (same_case && there.study() == new_job.study) return;
  throw RequestIdTaken("request_id \"" + new_job.request_id + "\" was used for another " +
                       (same_case ? "study" : "case") + " (job " + there.id() +
                       "); choose a new one");
}

/// Counts a submission as a waiting job from the first check of the queue to its place in it.
class Reservation {
public:
  Reservation(std::mutex& mutex, int& count) : mutex_(mutex), count_(count) { ++count_; }
  Reservation(const Reservation&) = delete;
  ~Reservation() {
    const std::lock_guard lock(mutex_);
    --count_;
  }

private:
  std::mutex& mutex_;
  int& count_;
};

/// Removes a folder whose job was not taken. The cause is on its way; recovery finds what is left.
void discard(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

}  // namespace

void Scheduler::require_room(std::int64_t bytes) {
  if (const std::string reason = held(); !reason.empty())
    throw StorageHeld("the queue is held and takes no job now: " + reason +
                      "; it goes on by itself once that has passed: submit again then");
  require_free_space(jobs_directory_, options_.minimum_free_bytes);
  const std::int64_t waiting = store_.unfinished_bytes();
  if (waiting + bytes > options_.maximum_waiting_bytes)
    throw QueueFull(
        "cases and attachments of the jobs that have not ended take " + std::to_string(waiting) +
        " bytes, this one " + std::to_string(bytes) + ", and maximum_waiting_bytes is " +
        std::to_string(options_.maximum_waiting_bytes) + "; submit again when some have ended");
}

v1::Job Scheduler::submit(const NewJob& new_job, const Attachments& attachments) {
  if (!new_job.request_id.empty()) {
    if (const auto there = store_.find_request(new_job.request_id)) {
      require_same_submission(there->job, new_job);
      return find(there->job.id()).value_or(there->job);
    }
  }
  JobRecord record = record_of_new(new_job, attachments);
  require_room(record.bytes);
  std::optional<Reservation> reservation;
  {
    const std::lock_guard lock(mutex_);
    if (shutting_down_) throw ShuttingDown("dccastd is shutting down; submit again later");
    if (static_cast<int>(queue_.size()) + submissions_under_way_ >= options_.maximum_queued)
      throw QueueFull("the queue is full (" + std::to_string(options_.maximum_queued) +
                      " jobs wait); submit again later");
    reservation.emplace(mutex_, submissions_under_way_);
  }
  if (const auto there = write_new_job(record, new_job, attachments)) {
    require_same_submission(*there, new_job);
    return find(there->id()).value_or(*there);
  }
  spdlog::info("job {}: QUEUED: submitted{}", record.job.id(),
               record.job.title().empty() ? "" : " as \"" + record.job.title() + "\"");
  const std::lock_guard lock(mutex_);
  queue_.push(record.job);
  changed_.notify_all();
  return view(std::move(record));
}

/// Stores a new job on disk: folder, event log, row. @return the job that has its request_id
/// already, because someone was faster; nothing of the new one is left then
std::optional<v1::Job> Scheduler::write_new_job(const JobRecord& record, const NewJob& new_job,
                                                const Attachments& attachments) {
  const auto folder = jobs_directory_ / record.job.id();
  create_job_folder(folder, attachments,
                    {record.job, new_job.submitted_case, new_job.complete_case});
  try {
    const auto log = logs_.open(record.job.id());
    v1::JobEvent event = state_event(record.job, "submitted");
    log->append(event);
    log->sync();
    storage::sync_directory(folder);
    const auto there = store_.insert(record, new_job.submitted_case, new_job.complete_case);
    if (!there) {
      mark_accepted(folder);
      return std::nullopt;
    }
    discard(folder);
    return there->job;
  } catch (...) {
    discard(folder);
    throw;
  }
}

v1::Job Scheduler::view(JobRecord record) const {
  v1::Job job = std::move(record.job);
  const bool queued = job.state() == v1::QUEUED;
  job.set_queue_position(queued ? queue_.position(job.id()) : 0);
  if (queued) job.set_held(hold_.reason());
  return job;
}

std::optional<JobRecord> Scheduler::record_of(const std::string& id) {
  if (const Attempt* attempt = attempts_.running(id)) return attempt->record;
  if (const Attempt* attempt = attempts_.leaving(id)) return attempt->record;
  return ledger_.find(id);
}

std::optional<v1::Job> Scheduler::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  auto record = record_of(id);
  if (!record) return std::nullopt;
  return view(std::move(*record));
}

std::shared_ptr<EventLog> Scheduler::log(const std::string& id) {
  auto log = logs_.open(id);
  const std::lock_guard lock(mutex_);
  if (log->terminal_event() || ledger_.pending(id) != nullptr) return log;
  const auto record = store_.find(id);
  if (!record || !is_terminal(record->job.state())) return log;
  // The end was on the disk before the store knew of it: the file was damaged since. Watchers must
  // see an end all the same.
  v1::JobEvent event = state_event(record->job, "ended; part of the event log is lost");
  log->append(event);
  return log;
}

std::vector<v1::Job> Scheduler::list(const JobStore::Page& page) {
  const std::lock_guard lock(mutex_);
  const auto positions = queue_.positions();
  std::vector<v1::Job> jobs;
  for (JobRecord& stored : store_.list(page)) {
    const std::string id = stored.job.id();
    const Attempt* attempt = attempts_.running(id);
    const JobRecord* kept = attempt != nullptr ? &attempt->record : ledger_.pending(id);
    v1::Job& job = jobs.emplace_back(kept != nullptr ? kept->job : std::move(stored.job));
    if (job.state() != v1::QUEUED) continue;
    job.set_held(hold_.reason());
    if (const auto position = positions.find(id); position != positions.end())
      job.set_queue_position(position->second);
  }
  return jobs;
}

int Scheduler::queued() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(queue_.size());
}

int Scheduler::running() {
  const std::lock_guard lock(mutex_);
  return attempts_.running();
}

std::string Scheduler::held() {
  const std::lock_guard lock(mutex_);
  return hold_.reason();
}

/// Brings a job that no worker runs into another state, out of the queue.
Reply Scheduler::settle_idle(JobRecord& record, v1::JobState to, const std::string& cause) {
  const std::string id = record.job.id();
  ledger_.transition(record, to, cause);
  queue_.erase(id);
  if (Attempt* attempt = attempts_.leaving(id)) {
    attempt->requeue = false;
    attempt->record = record;
  } else if (is_terminal(to)) {
    remove_run_files(jobs_directory_ / id);
  }
  take_news();
  return {Reply::Kind::done, view(record)};
}

Reply Scheduler::cancel(const std::string& id, const std::string& reason) {
  const auto held_open = log_if_any(id);
  const std::lock_guard lock(mutex_);
  if (Attempt* attempt = attempts_.running(id)) {
    if (attempt->record.requested_action != RequestedAction::cancel) {
      attempts_.request(*attempt, RequestedAction::cancel, reason);
      spdlog::info("job {}: {}; its worker is asked to stop", id, cancel_cause(attempt->record));
    }
    changed_.notify_all();
    return {Reply::Kind::done, view(attempt->record)};
  }
  auto record = record_of(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (is_terminal(record->job.state())) return {Reply::Kind::done, view(*record)};
  record->request_reason = reason;
  return settle_idle(*record, v1::CANCELLED, cancel_cause(*record));
}

Reply Scheduler::pause(const std::string& id) {
  const auto held_open = log_if_any(id);
  const std::lock_guard lock(mutex_);
  if (Attempt* attempt = attempts_.running(id)) {
    if (attempt->record.requested_action == RequestedAction::none) {
      attempts_.request(*attempt, RequestedAction::pause, "");
      spdlog::info("job {}: pause asked for; its worker goes on to a checkpoint", id);
    }
    changed_.notify_all();
    return {Reply::Kind::done, view(attempt->record)};
  }
  auto record = record_of(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (is_terminal(record->job.state())) return {Reply::Kind::wrong_state, view(*record)};
  if (record->job.state() == v1::PAUSED) return {Reply::Kind::done, view(*record)};
  return settle_idle(*record, v1::PAUSED, "paused by request");
}

Reply Scheduler::resume(const std::string& id) {
  const auto held_open = log_if_any(id);
  const std::lock_guard lock(mutex_);
  auto record = record_of(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (record->job.state() != v1::PAUSED) return {Reply::Kind::wrong_state, view(*record)};
  record->requested_action = RequestedAction::none;
  ledger_.transition(*record, v1::QUEUED, "resumed by request");
  if (Attempt* attempt = attempts_.leaving(id)) {
    attempt->requeue = true;
    attempt->record = *record;
  } else {
    queue_.push(record->job);
  }
  take_news();
  return {Reply::Kind::done, view(*record)};
}

Reply Scheduler::remove(const std::string& id) {
  std::optional<std::filesystem::path> removed;
  {
    const std::lock_guard lock(mutex_);
    const auto record = record_of(id);
    if (!record) return {Reply::Kind::not_found, {}};
    if (record->requested_action == RequestedAction::cancel && !is_terminal(record->job.state()))
      return {Reply::Kind::being_cancelled, view(*record)};
    if (!is_terminal(record->job.state()) || ledger_.pending(id) != nullptr)
      return {Reply::Kind::wrong_state, view(*record)};
    removed = begin_removal(jobs_directory_, id);
    try {
      store_.erase(id);
    } catch (const StoreError&) {
      if (removed) undo_removal(*removed);
      throw;
    }
  }
  // Without its row nobody asks for the folder any more; a large one takes its time.
  std::error_code error;
  if (removed) std::filesystem::remove_all(*removed, error);
  if (error) spdlog::warn("job {}: part of its folder is left: {}", id, error.message());
  spdlog::info("job {}: deleted by request", id);
  return {Reply::Kind::done, {}};
}

/// Opens a job's log, which may mean to scan it, before the mutex is taken.
std::shared_ptr<EventLog> Scheduler::log_if_any(const std::string& id) {
  return store_.find(id) ? logs_.open(id) : nullptr;
}

}  // namespace dccast::jobs
