// What clients ask of the scheduler: submit, look, cancel, pause, resume, delete.
#include <fmt/ranges.h>

#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/log.hpp"
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
    if (static_cast<int>(queue_.size() + dependents_.size()) + submissions_under_way_ >=
        options_.maximum_queued)
      throw QueueFull("the queue is full; maximum_queued = " +
                      std::to_string(options_.maximum_queued) + "; submit again later");
    reservation.emplace(mutex_, submissions_under_way_);
  }
  if (const auto there = write_new_job(record, new_job, attachments)) {
    require_same_submission(*there, new_job);
    return find(there->id()).value_or(*there);
  }
  log::info("job {}: QUEUED: submitted{}", record.job.id(),
            record.job.title().empty() ? "" : " as \"" + record.job.title() + "\"");
  const std::lock_guard lock(mutex_);
  enqueue(record.job, new_job.goes_first);
  changed_.notify_all();
  return view(std::move(record));
}

/// Stores a new job on disk: folder, event log, row. @return the job that has its request_id
/// already, because someone was faster; nothing of the new one is left then
std::optional<v1::Job> Scheduler::write_new_job(const JobRecord& record, const NewJob& new_job,
                                                const Attachments& attachments) {
  const auto folder = jobs_directory_ / record.job.id();
  create_job_folder(folder, attachments,
                    {record.job, new_job.submitted_case, new_job.complete_case, new_job.answer_key},
                    new_job.case_file);
  try {
    const auto log = logs_.open(record.job.id());
    v1::JobEvent event = state_event(record.job, "submitted");
    log->append(event);
    log->sync();
    storage::sync_directory(folder);
    const auto there = store_.insert(record);
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
  // An end that is written counts, although its attempt may still be there.
  const auto attempt = attempts_.find(record.job.id());
  if (attempt && !is_terminal(record.job.state())) return view(*attempt);
  v1::Job job = std::move(record.job);
  const bool queued = job.state() == v1::QUEUED;
  job.set_queue_position(queued ? queue_.position(job.id()) : 0);
  if (!queued) return job;
  if (hold_.holds())
    job.set_held(hold_.reason());
  else if (dependents_.contains(job.id()))
    job.set_held(fmt::format("waits for {}", fmt::join(job.after(), ", ")));
  else if (!user_may_start(job.owner()))
    job.set_held(fmt::format("{} has {} jobs running; maximum_running_per_user = {}", job.owner(),
                             attempts_.of_queue(job.owner()), options_.maximum_running_per_user));
  else
    foresee(job);
  return job;
}

/// When a job of the queue starts and ends, from what jobs took before. What holds it has no end
/// that could be known: this is for jobs that nothing holds.
void Scheduler::foresee(v1::Job& job) const {
  const double own_s = forecast_.run_s(job.estimated_s());
  const double each_s = forecast_.run_s(queue_.mean_estimated_s());
  if (own_s <= 0.0 || job.queue_position() == 0) return;
  constexpr std::chrono::milliseconds good_for{500};  // a list asks for each of its jobs
  if (const auto at = Clock::now(); at > left_at_ + good_for) {
    left_at_ = at;
    left_s_.clear();
    for (const auto& [id, attempt] : attempts_.by_job())
      if (!attempt->goes_first)
        left_s_.push_back(forecast_.left_s(view(*attempt), ran_s(*attempt, at)));
  }
  job.set_starts_in_s(
      Forecast::start_s(left_s_, executor_.capacity(), job.queue_position(), each_s));
  job.set_ends_in_s(job.starts_in_s() + own_s);
}

v1::Job Scheduler::view(const Attempt& attempt) const {
  v1::Job job = attempt.record.job;
  attempt.log->complete(job);
  job.set_held(attempt.waits.empty() ? attempt.stopped_for : attempt.waits);
  const double left_s = forecast_.left_s(job, ran_s(attempt, Clock::now()));
  if (job.state() == v1::RUNNING && attempt.waits.empty() && left_s > 0.0)
    job.set_ends_in_s(left_s);
  return job;
}

std::optional<v1::Job> Scheduler::find(const std::string& id) {
  auto record = ledger_.find(id);
  if (!record) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return view(std::move(*record));
}

std::shared_ptr<EventLog> Scheduler::log(const std::string& id) {
  auto log = logs_.open(id);
  const auto lacks_its_end = [&] {
    if (log->terminal_event()) return false;
    const auto record = store_.find(id);
    return record && is_terminal(record->job.state()) && !log->terminal_event();
  };
  if (!lacks_its_end()) return log;
  // Its end is being announced, or the file was damaged since: watchers must see an end all the
  // same.
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, id);
  lock.unlock();
  if (!lacks_its_end()) return log;
  v1::JobEvent event = state_event(store_.find(id).value(), "ended; part of the event log is lost");
  log->append(event);
  return log;
}

std::vector<v1::Job> Scheduler::list(const JobStore::Page& page) {
  std::vector<JobRecord> records = store_.list(page);
  const std::lock_guard lock(mutex_);
  std::vector<v1::Job> jobs;
  for (JobRecord& record : records) {
    if (auto kept = ledger_.kept(record.job.id())) record = std::move(*kept);
    jobs.push_back(view(std::move(record)));
  }
  return jobs;
}

bool Scheduler::turns(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  round_requested_ = true;
  changed_.notify_all();
  return changed_.wait_for(lock, longest, [this] { return !round_requested_; });
}

int Scheduler::queued() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(queue_.size() + dependents_.size());
}

int Scheduler::running() {
  const std::lock_guard lock(mutex_);
  return attempts_.running();
}

std::string Scheduler::held() {
  const std::lock_guard lock(mutex_);
  return hold_.reason();
}

/// Brings a job that no worker runs into another state.
Reply Scheduler::settle_idle(std::unique_lock<std::mutex>& lock, JobRecord& record, v1::JobState to,
                             const std::string& cause) {
  const std::string id = record.job.id();
  if (is_terminal(to)) record.bytes = bytes_kept(jobs_directory_ / id);
  ledger_.transition(record, to, cause);
  if (is_terminal(to)) remove_run_files(jobs_directory_ / id);
  lock.lock();
  if (to == v1::QUEUED)
    enqueue(record.job);
  else
    dequeue(id);
  changed_.notify_all();
  if (const std::string refusal = ledger_.refusal(); !refusal.empty()) hold(refusal);
  Reply reply{Reply::Kind::done, view(record)};
  lock.unlock();
  ledger_.announce(id);
  return reply;
}

Reply Scheduler::stop(const std::string& id, const Request& request) {
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, id);
  if (const auto attempt = attempts_.find(id)) {
    if (attempt->record.requested_action < request.action) {
      lock.unlock();
      write_request(jobs_directory_ / id, request);
      lock.lock();
      attempt->record.requested_action = request.action;
      attempt->record.request_reason = request.reason;
      attempts_.expect_stop(*attempt);
      log::info("job {}: {} requested", id,
                request.action == RequestedAction::cancel ? "cancel" : "pause");
      changed_.notify_all();
    }
    return {Reply::Kind::done, view(*attempt)};
  }
  lock.unlock();
  auto record = ledger_.find(id);
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

Reply Scheduler::resume(const std::string& id) {
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, id);
  if (const auto attempt = attempts_.find(id)) return {Reply::Kind::wrong_state, view(*attempt)};
  lock.unlock();
  auto record = ledger_.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (record->job.state() != v1::PAUSED) return {Reply::Kind::wrong_state, record->job};
  record->requested_action = RequestedAction::none;
  return settle_idle(lock, *record, v1::QUEUED, "resumed by request");
}

Reply Scheduler::remove(const std::string& id, const std::string& why,
                        const std::function<bool(const v1::Job& job)>& permits) {
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, id);
  if (const auto attempt = attempts_.find(id)) {
    const bool cancelled = attempt->record.requested_action == RequestedAction::cancel;
    return {cancelled ? Reply::Kind::being_cancelled : Reply::Kind::wrong_state, view(*attempt)};
  }
  lock.unlock();
  const auto record = ledger_.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (!is_terminal(record->job.state()) || ledger_.kept(id) || (permits && !permits(record->job)))
    return {Reply::Kind::wrong_state, record->job};
  const auto removed = begin_removal(jobs_directory_, id);
  try {
    store_.erase(id);
  } catch (const StoreError&) {
    if (removed) undo_removal(*removed);
    throw;
  }
  // Without its row nothing refers to the folder any more; a large one takes its time.
  std::error_code error;
  if (removed) std::filesystem::remove_all(*removed, error);
  if (error) log::warn("job {}: part of its folder is left: {}", id, error.message());
  ledger_.report(record->job);
  log::info("job {}: deleted, {}", id, why);
  lock.lock();
  look_at_those_after(id);
  changed_.notify_all();
  return {Reply::Kind::done, {}};
}

Reply Scheduler::mark(const std::string& id, const std::function<void(v1::Job& job)>& change) {
  std::unique_lock lock(mutex_);
  const Exclusive exclusive(*this, lock, id);
  lock.unlock();
  auto record = ledger_.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  const v1::Job before = record->job;
  v1::Job& job = record->job;
  change(job);
  write_marks(jobs_directory_ / id, job);
  try {
    store_.update_marks(job);
  } catch (const StoreError&) {
    write_marks(jobs_directory_ / id, before);
    throw;
  }
  ledger_.change_kept(job);
  log::info("job {}: labels {}, {}", id, fmt::join(job.labels(), ", "),
            job.pinned() ? "pinned" : "not pinned");
  lock.lock();
  if (const auto attempt = attempts_.find(id)) {
    *attempt->record.job.mutable_labels() = job.labels();
    attempt->record.job.set_pinned(job.pinned());
  }
  return {Reply::Kind::done, view(std::move(*record))};
}

}  // namespace dccast::jobs
