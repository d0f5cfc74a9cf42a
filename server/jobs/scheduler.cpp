// The queue's own life: what is started when, what holds it, what its workers report. Requests of
// clients are in scheduler_requests.cpp.
#include "server/jobs/scheduler.hpp"

#include <algorithm>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/free_space.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/jobs/recovery.hpp"
#include "server/jobs/storage_fault.hpp"

namespace dccast::jobs {

namespace {

/// A thread that wakes later than this was not only kept waiting: the process stood still.
constexpr std::chrono::milliseconds standstill{250};

}  // namespace

Scheduler::Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor)
    : options_(std::move(options)),
      jobs_directory_(options_.attempts.jobs_directory),
      store_(store),
      logs_(logs),
      executor_(executor),
      ledger_(store, logs),
      attempts_(options_.attempts, store, logs, ledger_, executor) {
  const auto told = [this](auto tell) {
    return [this, tell](const std::string& job_id, int number, const std::string& text) {
      const std::lock_guard lock(mutex_);
      (attempts_.*tell)(job_id, number, text);
      take_news();
    };
  };
  executor_.set_calls({.started = told(&Attempts::worker_started),
                       .not_started = told(&Attempts::worker_not_started),
                       .ended = told(&Attempts::worker_ended)});
}

Scheduler::~Scheduler() {
  if (thread_.joinable()) shut_down();
}

void Scheduler::recover() {
  const std::lock_guard lock(mutex_);
  RecoveredJobs recovered = recover_jobs(jobs_directory_, store_, logs_, ledger_, executor_);
  for (const v1::Job& job : recovered.waiting) queue_.push(job);
  for (JobRecord& record : recovered.with_worker) attempts_.adopt(std::move(record));
  quarantine_unknown_folders(jobs_directory_, store_.ids());
  take_news();
}

void Scheduler::start() {
  expected_wake_ = Clock::now();
  thread_ = std::thread([this] { run(); });
}

void Scheduler::shut_down() {
  std::unique_lock lock(mutex_);
  shutting_down_ = true;
  attempts_.stop_all();
  changed_.notify_all();
  changed_.wait(lock, [this] { return attempts_.count() == 0; });
  stopping_ = true;
  changed_.notify_all();
  lock.unlock();
  thread_.join();
}

void Scheduler::let_workers_run() {
  std::unique_lock lock(mutex_);
  shutting_down_ = stopping_ = true;
  changed_.notify_all();
  lock.unlock();
  thread_.join();
}

void Scheduler::run() {
  std::unique_lock lock(mutex_);
  expected_wake_ = Clock::now();
  while (!stopping_) {
    notice_standstill();
    attempts_.kill_overdue(Clock::now());
    take_news();
    lock.unlock();
    look_whether_hold_has_passed();
    start_jobs();
    lock.lock();
    if (stopping_) return;
    if (may_start() && queue_.front()) continue;
    expected_wake_ = next_deadline();
    changed_.wait_until(lock, expected_wake_);
  }
}

void Scheduler::notice_standstill() {
  const auto now = Clock::now();
  if (now > expected_wake_ + standstill) attempts_.forgive_silences(now);
}

Scheduler::Clock::time_point Scheduler::next_deadline() const {
  const auto deadline = attempts_.next_deadline();
  return hold_.holds() ? std::min(deadline, hold_.next_look()) : deadline;
}

void Scheduler::take_news() {
  const AttemptNews news = attempts_.take_news();
  for (const v1::Job& job : news.requeued) queue_.push(job);
  for (const std::string& lack : {news.daemon_lacks, ledger_.trouble()})
    if (!lack.empty()) hold(lack);
  changed_.notify_all();
}

void Scheduler::hold(const std::string& reason) {
  if (hold_.set(reason))
    spdlog::error("the queue is held, no job fails for it: {}; looking again every few seconds",
                  reason);
}

void Scheduler::look_whether_hold_has_passed() {
  {
    const std::lock_guard lock(mutex_);
    if (!hold_.holds() || Clock::now() < hold_.next_look()) return;
  }
  const std::string trouble = storage_trouble();  // waits for the disk: outside of the mutex
  const std::lock_guard lock(mutex_);
  if (!trouble.empty() || !ledger_.retry()) return hold_.look_again_later();
  spdlog::info("the queue goes on; it was held: {}", hold_.reason());
  hold_.lift();
}

std::string Scheduler::storage_trouble() {
  try {
    require_free_space(jobs_directory_, options_.minimum_free_bytes);
    probe_directory(jobs_directory_);
    store_.probe();
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

bool Scheduler::may_start() {
  return !shutting_down_ && !hold_.holds() && attempts_.count() < executor_.capacity();
}

void Scheduler::start_jobs() {
  while (start_next()) {
  }
}

/// @return whether there may be another job to start
bool Scheduler::start_next() {
  std::optional<std::string> id;
  {
    const std::lock_guard lock(mutex_);
    id = may_start() ? queue_.front() : std::nullopt;
  }
  if (!id) return false;
  std::shared_ptr<EventLog> held_open;  // so that nothing scans a long log under the mutex
  try {
    require_free_space(jobs_directory_, options_.minimum_free_bytes);
    held_open = logs_.open(*id);
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    refuse_start(*id, error);
    return true;
  }
  const std::lock_guard lock(mutex_);
  if (!may_start() || queue_.front() != id) return true;
  try {
    auto record = ledger_.find(*id);
    if (record && record->job.state() == v1::QUEUED) attempts_.begin(std::move(*record));
    queue_.erase(*id);
  } catch (const std::exception& error) {
    refuse_start(*id, error);
  }
  take_news();
  return true;
}

/// A job that cannot be started waits for the missing resource; it fails only for its own files.
void Scheduler::refuse_start(const std::string& id, const std::exception& error) {
  if (const auto lack = daemon_lacks(error)) return hold(*lack);
  try {
    fail_waiting(id, error.what());
  } catch (const std::exception& unreadable) {  // the store: what becomes of the job is seen later
    hold(unreadable.what());
  }
}

void Scheduler::fail_waiting(const std::string& id, const std::string& why) {
  auto record = ledger_.find(id);
  queue_.erase(id);
  if (!record || record->job.state() != v1::QUEUED) return;
  add_failure(record->job, v1::Failure::STORAGE, why);
  ledger_.settle(*record, v1::FAILED, why);
  take_news();
}

std::shared_ptr<Attempt> Scheduler::attach(const v1::WorkerMessage::Hello& hello,
                                           std::shared_ptr<WorkerChannel> channel) {
  const std::lock_guard lock(mutex_);
  auto attempt = attempts_.attach(hello, std::move(channel));
  changed_.notify_all();  // from now on other deadlines hold
  return attempt;
}

void Scheduler::report(const std::shared_ptr<Attempt>& attempt, const v1::WorkerMessage& message) {
  Attempts::note_word(*attempt);
  v1::JobEvent event;
  switch (message.what_case()) {
    case v1::WorkerMessage::kStep:
      *event.mutable_step() = message.step();
      return hear(attempt, std::move(event));
    case v1::WorkerMessage::kMessage:
      *event.mutable_message() = message.message();
      return hear(attempt, std::move(event));
    case v1::WorkerMessage::kResumed:
      spdlog::info("job {}: resumed from the checkpoint of step {}", attempt->job_id,
                   message.resumed().step());
      *event.mutable_resumed() = message.resumed();
      return hear(attempt, std::move(event));
    case v1::WorkerMessage::kValidityLost:
      return note_validity_loss(attempt, message.validity_lost());
    case v1::WorkerMessage::kFinding:
      return note_finding(attempt, message.finding());
    case v1::WorkerMessage::kFinished: {
      const std::lock_guard lock(mutex_);
      attempts_.finish(*attempt, message.finished());
      return take_news();
    }
    case v1::WorkerMessage::kHeartbeat:
      return;
    case v1::WorkerMessage::kHello:
    case v1::WorkerMessage::WHAT_NOT_SET:
      spdlog::warn("job {}: its worker sent an unexpected message", attempt->job_id);
  }
}

/// A run that goes on from a checkpoint says again what was lost before.
void Scheduler::note_validity_loss(const std::shared_ptr<Attempt>& attempt,
                                   const v1::ValidityLoss& loss) {
  {
    const std::lock_guard lock(mutex_);
    if (attempt->log->has_validity_loss()) return;
    attempts_.note_validity_loss(*attempt, loss);
  }
  v1::JobEvent event;
  *event.mutable_validity_lost() = loss;
  hear(attempt, std::move(event));
}

/// A worker repeats its findings after a resumption; only one that has changed, by a worse
/// exceedance, is an event.
void Scheduler::note_finding(const std::shared_ptr<Attempt>& attempt, const v1::Finding& finding) {
  if (attempt->log->has(finding)) return;
  v1::JobEvent event;
  *event.mutable_finding() = finding;
  hear(attempt, std::move(event));
}

void Scheduler::hear(const std::shared_ptr<Attempt>& attempt, v1::JobEvent event) {
  const std::string error = Attempts::hear(*attempt, std::move(event));
  if (error.empty()) return;
  spdlog::error("job {}: {}; its worker is asked to stop", attempt->job_id, error);
  const std::lock_guard lock(mutex_);
  if (!attempt->settled) attempts_.order_stop(*attempt, true);
  hold(error);
  changed_.notify_all();
}

void Scheduler::detach(const std::shared_ptr<Attempt>& attempt) {
  const std::lock_guard lock(mutex_);
  attempts_.detach(attempt);
  take_news();
}

}  // namespace dccast::jobs
