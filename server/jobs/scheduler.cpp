#include "server/jobs/scheduler.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "proto/values/uuid.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/quarantine.hpp"

namespace dccast::jobs {

namespace {

constexpr std::chrono::seconds settlement_retry_interval{1};

v1::Job new_job_message(const NewJob& new_job) {
  v1::Job job;
  job.set_id(values::random_uuid());
  job.set_title(new_job.title);
  job.set_state(v1::QUEUED);
  job.set_priority(new_job.priority == v1::PRIORITY_UNSPECIFIED ? v1::NORMAL : new_job.priority);
  job.set_request_id(new_job.request_id);
  job.set_study(new_job.study);
  job.set_case_sha256(new_job.case_sha256);
  *job.mutable_create_time() = timestamp(milliseconds(now()));  // as exactly as the store keeps it
  return job;
}

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

}  // namespace

Scheduler::Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor)
    : options_(std::move(options)), store_(store), logs_(logs), executor_(executor) {
  executor_.set_calls(
      {.started = [this](const std::string& job_id, int attempt,
                         ProcessIdentity worker) { worker_started(job_id, attempt, worker); },
       .ended = [this](const std::string& job_id, int attempt,
                       const std::string& how) { worker_ended(job_id, attempt, how); }});
}

Scheduler::~Scheduler() {
  if (thread_.joinable()) shut_down();
}

void Scheduler::start() {
  thread_ = std::thread([this] { run(); });
}

void Scheduler::shut_down() {
  std::unique_lock lock(mutex_);
  shutting_down_ = true;
  for (const auto& [id, run] : runs_)
    if (!run->settled) order_stop(*run, true);
  changed_.notify_all();
  changed_.wait(lock, [this] { return runs_.empty(); });
  stopping_ = true;
  changed_.notify_all();
  lock.unlock();
  thread_.join();
}

v1::Job Scheduler::submit(const NewJob& new_job, const Attachments& attachments) {
  if (!new_job.request_id.empty()) {
    if (const auto there = store_.find_request(new_job.request_id)) {
      require_same_submission(there->job, new_job);
      return find(there->job.id()).value_or(there->job);
    }
  }
  std::optional<Reservation> reservation;
  {
    const std::lock_guard lock(mutex_);
    if (shutting_down_) throw ShuttingDown("dccastd is shutting down; submit again later");
    if (static_cast<int>(queue_.size()) + submissions_under_way_ >= options_.maximum_queued)
      throw QueueFull("the queue is full (" + std::to_string(options_.maximum_queued) +
                      " jobs wait); submit again later");
    reservation.emplace(mutex_, submissions_under_way_);
  }
  JobRecord record;
  record.job = new_job_message(new_job);
  const auto folder = options_.jobs_directory / record.job.id();
  create_job_folder(folder, attachments,
                    {record.job, new_job.submitted_case, new_job.complete_case});
  try {
    const auto log = logs_.open(record.job.id());
    v1::JobEvent event = state_event(record.job, "submitted");
    log->append(event);
    log->sync();
    sync_directory(folder);
    const auto there = store_.insert(record, new_job.submitted_case, new_job.complete_case);
    if (there) {  // someone was faster with the same request_id
      std::filesystem::remove_all(folder);
      require_same_submission(there->job, new_job);
      return find(there->job.id()).value_or(there->job);
    }
  } catch (const RequestIdTaken&) {
    throw;
  } catch (...) {
    std::error_code ignored;  // the cause is on its way; the next start moves aside what is left
    std::filesystem::remove_all(folder, ignored);
    throw;
  }
  mark_accepted(folder);
  spdlog::info("job {}: QUEUED: submitted{}", record.job.id(),
               record.job.title().empty() ? "" : " as \"" + record.job.title() + "\"");
  const std::lock_guard lock(mutex_);
  queue_.push(record.job);
  changed_.notify_all();
  return view(std::move(record));
}

v1::Job Scheduler::view(JobRecord record) {
  v1::Job job = std::move(record.job);
  job.set_queue_position(job.state() == v1::QUEUED ? queue_.position(job.id()) : 0);
  return job;
}

JobRecord* Scheduler::active_record(const std::string& id) {
  if (const auto unsettled = unsettled_.find(id); unsettled != unsettled_.end())
    return &unsettled->second.record;
  const auto run = runs_.find(id);
  if (run == runs_.end()) return nullptr;
  if (!run->second->settled)
    if (const auto step = run->second->log->last_step())
      *run->second->record.job.mutable_last_step() = *step;
  return &run->second->record;
}

std::optional<v1::Job> Scheduler::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  if (const JobRecord* record = active_record(id)) return view(*record);
  auto record = store_.find(id);
  if (!record) return std::nullopt;
  return view(std::move(*record));
}

std::shared_ptr<EventLog> Scheduler::log(const std::string& id) {
  const std::lock_guard lock(mutex_);
  auto log = logs_.open(id);
  if (log->terminal_event() || unsettled_.contains(id)) return log;
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
  for (JobRecord& record : store_.list(page)) {
    const JobRecord* active = active_record(record.job.id());
    jobs.push_back(active ? active->job : std::move(record.job));
    const auto position = positions.find(jobs.back().id());
    if (position != positions.end()) jobs.back().set_queue_position(position->second);
  }
  return jobs;
}

int Scheduler::queued() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(queue_.size());
}

int Scheduler::running() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(
      std::ranges::count_if(runs_, [](const auto& entry) { return !entry.second->settled; }));
}

Reply Scheduler::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto record = store_.find(id);
  if (!record) return {Reply::Kind::not_found, {}};
  if (!is_terminal(record->job.state()) || unsettled_.contains(id))
    return {Reply::Kind::wrong_state, view(*record)};
  const auto removed = begin_removal(options_.jobs_directory, id);
  try {
    store_.erase(id);
  } catch (const StoreError&) {
    if (removed) undo_removal(*removed);
    throw;
  }
  if (removed) std::filesystem::remove_all(*removed);
  spdlog::info("job {}: deleted by request", id);
  return {Reply::Kind::done, record->job};
}

Reply Scheduler::resume(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto run = runs_.find(id);
  auto stored = run == runs_.end() ? store_.find(id) : std::nullopt;
  if (run == runs_.end() && !stored) return {Reply::Kind::not_found, {}};
  JobRecord& record = stored ? *stored : run->second->record;
  if (record.job.state() != v1::PAUSED) return {Reply::Kind::wrong_state, view(record)};
  record.wish = Wish::none;
  transition(record, v1::QUEUED, "resumed by request");
  if (stored)
    queue_.push(record.job);
  else
    run->second->requeue = true;
  changed_.notify_all();
  return {Reply::Kind::done, view(record)};
}

void Scheduler::transition(JobRecord& record, v1::JobState to, const std::string& cause) {
  const v1::JobState from = record.job.state();
  v1::Job& job = record.job;
  const bool terminal = is_terminal(to);
  const auto log = logs_.open(job.id());
  job.set_state(to);
  if (terminal) {
    job.set_queue_position(0);
    if (!job.has_end_time()) *job.mutable_end_time() = timestamp(milliseconds(now()));
  }
  if (const auto step = log->last_step()) *job.mutable_last_step() = *step;
  if (!(terminal && log->terminal_event())) {
    v1::JobEvent event = state_event(job, cause);
    log->append(event);
  }
  // The event is on the disk before the store says so: a start after a crash finds the event at
  // least, and completes the store.
  if (terminal) log->sync();
  store_.update(record, terminal ? Durability::full : Durability::normal);
  spdlog::info("job {}: {} -> {}: {}", job.id(), v1::JobState_Name(from), v1::JobState_Name(to),
               cause);
}

void Scheduler::settle(JobRecord& record, v1::JobState to, const std::string& cause) {
  try {
    transition(record, to, cause);
  } catch (const std::exception& error) {
    spdlog::error("job {}: cannot store that it is {}: {}", record.job.id(), v1::JobState_Name(to),
                  error.what());
    if (!is_terminal(to)) {
      auto* failure = record.job.mutable_failure();
      failure->set_kind(v1::Failure::STORAGE);
      failure->set_message(error.what());
      record.job.set_state(v1::FAILED);
    }
    unsettled_[record.job.id()] = {record, cause};
    next_retry_ = Clock::now() + settlement_retry_interval;
  }
}

void Scheduler::retry_settlements() {
  if (unsettled_.empty() || Clock::now() < next_retry_) return;
  next_retry_ = Clock::now() + settlement_retry_interval;
  for (auto at = unsettled_.begin(); at != unsettled_.end();) {
    JobRecord& record = at->second.record;
    try {
      transition(record, record.job.state(), at->second.cause);
      at = unsettled_.erase(at);
    } catch (const std::exception&) {
      ++at;  // said when it failed first; the next try comes in a second
    }
  }
}

Scheduler::Clock::time_point Scheduler::next_deadline() const {
  Clock::time_point deadline = Clock::now() + std::chrono::hours(1);
  for (const auto& [id, run] : runs_)
    if (run->kill_at) deadline = std::min(deadline, *run->kill_at);
  if (!unsettled_.empty()) deadline = std::min(deadline, next_retry_);
  return deadline;
}

void Scheduler::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    kill_overdue();
    retry_settlements();
    start_next();
    changed_.wait_until(lock, next_deadline());
  }
}

}  // namespace dccast::jobs
