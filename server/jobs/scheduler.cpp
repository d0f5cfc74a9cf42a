// The queue's own life: what is started when, what holds it, what its workers report.
#include "server/jobs/scheduler.hpp"

#include "server/jobs/log.hpp"

#include <algorithm>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"

namespace dccast::jobs {

namespace {

/// A thread that wakes later than this was not only kept waiting: the process stood still.
constexpr std::chrono::milliseconds standstill{250};

}  // namespace

Scheduler::Exclusive::Exclusive(Scheduler& scheduler, std::unique_lock<std::mutex>& lock,
                                const std::string& id)
    : scheduler_(scheduler), lock_(lock), id_(id) {
  scheduler_.changed_.wait(lock_, [this] { return !scheduler_.held_jobs_.contains(id_); });
  scheduler_.held_jobs_.insert(id_);
}

Scheduler::Exclusive::~Exclusive() {
  if (!lock_.owns_lock()) lock_.lock();
  scheduler_.held_jobs_.erase(id_);
  scheduler_.changed_.notify_all();
}

Scheduler::Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor)
    : options_(std::move(options)),
      jobs_directory_(options_.attempts.jobs_directory),
      store_(store),
      logs_(logs),
      executor_(executor),
      ledger_(store, logs),
      attempts_(options_.attempts, executor),
      queue_(options_.share_half_life) {
  const auto noted = [this](auto note) {
    return [this, note](const std::string& job_id, int number, const auto& what) {
      const std::lock_guard lock(mutex_);
      (attempts_.*note)(job_id, number, what);
      changed_.notify_all();
    };
  };
  executor_.set_calls({.not_started = noted(&Attempts::worker_not_started),
                       .ended = noted(&Attempts::worker_ended),
                       .waits = noted(&Attempts::worker_waits),
                       .stopped = noted(&Attempts::worker_stopped)});
}

Scheduler::~Scheduler() {
  if (thread_.joinable()) shut_down();
}

/// What a job has taken of the processors, beyond what was charged for its starts.
void Scheduler::charge(const v1::Job& job, std::int64_t at_ms) {
  const double taken = std::max(job.last_step().process_s(), job.last_step().solver_s());
  queue_.charge(job.owner(), std::max(0.0, taken - job.attempts() * JobQueue::start_charge_s),
                at_ms);
}

void Scheduler::start() {
  executor_.end_adoption();
  expected_wake_ = Clock::now();
  thread_ = std::thread([this] { run(); });
}

void Scheduler::shut_down() {
  std::unique_lock lock(mutex_);
  shutting_down_ = true;
  attempts_.stop_all();
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
    if (std::exchange(round_requested_, false)) changed_.notify_all();
    if (Clock::now() > expected_wake_ + standstill) attempts_.forgive_silences(Clock::now());
    attempts_.kill_overdue(Clock::now());
    lock.unlock();
    conclude_ended();
    look_whether_hold_has_passed();
    settle_dependents();
    while (start_next()) {
    }
    lock.lock();
    // What the disk does not take now the next daemon reads in the folders of the jobs.
    const bool leaves_no_worker =
        attempts_.by_job().empty() || (hold_.holds() && attempts_.running() == 0);
    if (stopping_ || (shutting_down_ && leaves_no_worker)) return;
    if (round_requested_ ||
        (!hold_.holds() &&
         (!attempts_.ended().empty() || !to_look_at_.empty() || (may_start() && next_job())))) {
      expected_wake_ = Clock::now();
      continue;
    }
    expected_wake_ = attempts_.next_deadline();
    if (hold_.holds()) expected_wake_ = std::min(expected_wake_, hold_.next_look());
    changed_.wait_until(lock, expected_wake_);
  }
}

void Scheduler::conclude_ended() {
  std::vector<std::shared_ptr<Attempt>> ended;
  {
    const std::lock_guard lock(mutex_);
    if (!hold_.holds()) ended = attempts_.ended();
  }
  for (const auto& attempt : ended) conclude(attempt);
}

/// Decides and writes what a job becomes whose worker has gone. What the disk does not take is
/// tried again once it does; until then the job is as it was.
void Scheduler::conclude(const std::shared_ptr<Attempt>& attempt) {
  const auto folder = jobs_directory_ / attempt->job_id;
  std::unique_lock lock(mutex_);
  const Exclusive job(*this, lock, attempt->job_id);
  JobRecord record = attempt->record;
  if (attempt->not_started.empty()) record.job.set_run_s(ran_s(*attempt, Clock::now()));
  AttemptFacts facts = attempts_.facts_of(*attempt);
  lock.unlock();
  Settlement settlement;
  try {
    if (attempt->not_started.empty()) {
      settlement = settle(record, *attempt->log, folder, attempt->exit, std::move(facts));
    } else {  // the job waits as if this attempt had not been
      record.job.set_attempts(attempt->number - 1);
      settlement = settle_stopped(record, attempt->not_started);
      settlement.daemon_lacks = attempt->not_started;
    }
    if (is_terminal(settlement.state)) record.bytes = bytes_kept(folder);
    ledger_.settle(record, settlement.state, settlement.cause);
  } catch (const std::exception& error) {
    lock.lock();
    return hold(error.what());
  }
  remove_request(folder);
  if (is_terminal(record.job.state())) remove_run_files(folder);
  lock.lock();
  attempts_.count_storage_failure(*attempt, settlement, attempt->log->content().reached_step);
  attempts_.erase(*attempt);
  if (record.job.state() == v1::QUEUED) queue_.push(record.job);
  if (is_terminal(record.job.state())) {
    look_at_those_after(attempt->job_id);
    attempt->log->complete(record.job);
    forecast_.learn(record.job);
    charge(record.job, milliseconds(now()));
  }
  for (const std::string& lack : {settlement.daemon_lacks, ledger_.refusal()})
    if (!lack.empty()) hold(lack);
  lock.unlock();
  ledger_.announce(attempt->job_id);
}

void Scheduler::hold(const std::string& reason) {
  if (hold_.set(reason))
    log::error("the queue is held, no job fails for it: {}; looking again every few seconds",
               reason);
  changed_.notify_all();
}

void Scheduler::look_whether_hold_has_passed() {
  {
    const std::lock_guard lock(mutex_);
    if (!hold_.holds() || Clock::now() < hold_.next_look()) return;
  }
  bool passed = false;
  try {  // waits for the disk: outside of the mutex
    require_free_space(jobs_directory_, options_.minimum_free_bytes);
    probe_directory(jobs_directory_);
    store_.probe();
    passed = ledger_.retry();
  } catch (const std::exception&) {
    // It is as it was, and the reason for it is known.
  }
  const std::lock_guard lock(mutex_);
  if (!passed) return hold_.look_again_later();
  log::info("the queue goes on; it was held: {}", hold_.reason());
  hold_.lift();
  changed_.notify_all();
}

bool Scheduler::may_start() const {
  return !shutting_down_ && !hold_.holds() &&
         (attempts_.of_queue() < executor_.capacity() || queue_.front_goes_first());
}

/// Their attempts that go first are beside the queue, and do not count.
bool Scheduler::user_may_start(const std::string& owner) const {
  return options_.maximum_running_per_user == 0 ||
         attempts_.of_queue(owner) < options_.maximum_running_per_user;
}

std::optional<std::string> Scheduler::next_job() const {
  return queue_.front([this](const std::string& owner) { return user_may_start(owner); });
}

/// @return whether there may be another job to start
bool Scheduler::start_next() {
  std::unique_lock lock(mutex_);
  const auto id = may_start() ? next_job() : std::nullopt;
  if (!id) return false;
  const Exclusive job(*this, lock, *id);
  if (!may_start() || next_job() != id) return true;
  lock.unlock();
  try {
    auto [record, log] = begin_attempt(*id);
    lock.lock();
    const bool goes_first = queue_.front_goes_first() && queue_.front() == id;
    queue_.erase(*id);
    if (!log) return true;  // it waits no more
    queue_.charge(record.job.owner(), JobQueue::start_charge_s, milliseconds(now()));
    const auto attempt = attempts_.add(std::move(record), std::move(log), false);
    attempt->goes_first = goes_first;
    attempts_.start(*attempt);
    if (const std::string fault = ledger_.refusal(); !fault.empty()) hold(fault);
  } catch (const std::exception& error) {
    refuse_start(*id, error);
    return true;
  }
  lock.unlock();
  ledger_.announce(*id);
  return true;
}

/// Writes that a job runs. @return no log for a job that does not wait
std::pair<JobRecord, std::shared_ptr<EventLog>> Scheduler::begin_attempt(const std::string& id) {
  require_free_space(jobs_directory_, options_.minimum_free_bytes);
  auto record = ledger_.find(id);
  if (!record || record->job.state() != v1::QUEUED) return {};
  auto log = logs_.open(id);
  remove_request(jobs_directory_ / id);  // that a crash has left
  v1::Job& job = record->job;
  job.set_attempts(job.attempts() + 1);
  if (!job.has_start_time()) *job.mutable_start_time() = timestamp(milliseconds(now()));
  ledger_.transition(*record, v1::RUNNING,
                     job.attempts() == 1
                         ? "started"
                         : "started again (attempt " + std::to_string(job.attempts()) + ")");
  log->announce();
  log->hand_over();
  logs_.follow(id);
  return {std::move(*record), std::move(log)};
}

/// A job that cannot be started waits for the missing resource; it fails only for its own files.
void Scheduler::refuse_start(const std::string& id, const std::exception& error) {
  try {
    if (const auto lack = daemon_lacks(error)) throw std::runtime_error(*lack);
    auto record = ledger_.find(id);
    if (record && record->job.state() == v1::QUEUED) {
      add_failure(record->job, v1::Failure::STORAGE, error.what());
      ledger_.settle(*record, v1::FAILED, error.what());
      ledger_.announce(id);
    }
    const std::lock_guard lock(mutex_);
    dequeue(id);
  } catch (const std::exception& lack) {  // what becomes of the job is seen later
    const std::lock_guard lock(mutex_);
    hold(lack.what());
  }
}

}  // namespace dccast::jobs
