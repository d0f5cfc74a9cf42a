#include "server/jobs/queue/queue_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

/// A thread that wakes later than this was not only delayed: the process was suspended.
constexpr std::chrono::milliseconds standstill{250};

/// How often it is seen whether the owners of castings that are followed may still have them.
constexpr std::chrono::seconds between_checks_of_owners{1};

/// How often the clock is read while jobs wait for their time: it may be set meanwhile.
constexpr std::chrono::seconds between_looks_at_clock{1};

/// Whether a job has ended so, or still may, as others wait for it.
enum class Awaited { reached, open, missed };
Awaited judge(const std::optional<JobRecord>& record, v1::AwaitedEnd end) {
  const v1::JobState state = record ? record->job.state() : v1::JOB_STATE_UNSPECIFIED;
  if (record && !is_terminal(state)) return Awaited::open;
  return ends_as_awaited(state, end) ? Awaited::reached : Awaited::missed;
}

/// "job X, which had to succeed first, has failed".
std::string describe_miss(const std::string& before, const std::optional<JobRecord>& record,
                          v1::AwaitedEnd end) {
  const v1::JobState state = record ? record->job.state() : v1::JOB_STATE_UNSPECIFIED;
  const char* how = state == v1::SUCCEEDED   ? "has succeeded"
                    : state == v1::CANCELLED ? "was cancelled"
                    : state == v1::FAILED    ? "has failed"
                                             : "was deleted";
  return fmt::format("job {}, which had to {} first, {}", before,
                     end == v1::AWAITED_FAILURE ? "fail" : "succeed", how);
}

/// How often the free space is looked at, also while no job waits: clients and monitors are told.
constexpr std::chrono::seconds between_looks_at_disk{5};

}  // namespace

QueueLoop::~QueueLoop() {
  if (thread_.joinable()) shut_down();
}

void QueueLoop::start() {
  expected_wake_ = Clock::now();
  thread_ = std::thread([this] { run(); });
}

void QueueLoop::shut_down() {
  {
    const std::lock_guard lock(state_.mutex);
    state_.shutting_down = true;
    state_.attempts.stop_all();
    state_.changed.notify_all();
  }
  thread_.join();
}

void QueueLoop::let_workers_run() {
  {
    const std::lock_guard lock(state_.mutex);
    state_.shutting_down = stopping_ = true;
    state_.changed.notify_all();
  }
  thread_.join();
}

bool QueueLoop::is_responsive(std::chrono::milliseconds longest) {
  std::unique_lock lock(state_.mutex);
  round_requested_ = true;
  state_.changed.notify_all();
  return state_.changed.wait_for(lock, longest, [this] { return !round_requested_; });
}

void QueueLoop::run() {
  std::unique_lock lock(state_.mutex);
  expected_wake_ = Clock::now();
  while (!stopping_) {
    if (std::exchange(round_requested_, false)) state_.changed.notify_all();

    // Waking much too late means that the daemon was suspended: it has missed heartbeats.
    if (Clock::now() > expected_wake_ + standstill) state_.attempts.forgive_silences(Clock::now());
    state_.attempts.kill_overdue(Clock::now());

    lock.unlock();  // these write to disk
    settle_ended_attempts();
    hold_if_disk_is_full();
    resume_after_hold();
    release_dependents();
    release_begun();
    end_castings_of_refused_owners();
    while (start_next()) {
    }
    lock.lock();

    if (may_end()) return;
    if (has_work()) {
      expected_wake_ = Clock::now();
      continue;
    }

    expected_wake_ = state_.attempts.next_deadline();
    if (owner_refusal_ && state_.attempts.count_in(Lane::followed) > 0)
      expected_wake_ = std::min(expected_wake_, owners_checked_ + between_checks_of_owners);
    expected_wake_ =
        std::min(expected_wake_, state_.queue_hold.holds() ? state_.queue_hold.next_check()
                                                           : disk_checked_ + between_looks_at_disk);
    if (state_.begins.size() > 0)
      expected_wake_ = std::min(expected_wake_, Clock::now() + between_looks_at_clock);
    state_.changed.wait_until(lock, expected_wake_);
  }
}

/// Changes that cannot be written now are recovered from the job folders at the next start.
bool QueueLoop::may_end() const {
  const Attempts& attempts = state_.attempts;
  const bool leaves_no_worker =
      attempts.by_job().empty() || (state_.queue_hold.holds() && attempts.running() == 0);
  return stopping_ || (state_.shutting_down && leaves_no_worker);
}

bool QueueLoop::has_work() const {
  if (round_requested_) return true;
  if (state_.queue_hold.holds()) return false;
  return !state_.attempts.ended().empty() || state_.dependents.has_next() ||
         (may_start() && next_job());
}

void QueueLoop::settle_ended_attempts() {
  std::vector<std::shared_ptr<Attempt>> ended;
  {
    const std::lock_guard lock(state_.mutex);
    if (!state_.queue_hold.holds()) ended = state_.attempts.ended();
  }
  for (const auto& attempt : ended) settle_attempt(attempt);
}

/// Decides and writes the outcome of a job whose worker has ended. If it cannot be written, the
/// queue is held and the job stays as it is until the next try.
void QueueLoop::settle_attempt(const std::shared_ptr<Attempt>& attempt) {
  const auto folder = state_.jobs_directory / attempt->job_id;
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, attempt->job_id);

  JobRecord record = attempt->record;
  if (attempt->not_started.empty()) record.job.set_run_s(ran_s(*attempt, Clock::now()));
  AttemptFacts facts = state_.attempts.facts(*attempt);
  lock.unlock();

  Settlement settlement;
  try {
    settlement = decide(*attempt, record, std::move(facts));
    if (is_terminal(settlement.state)) record.bytes = bytes_kept(folder);
    state_.ledger.settle(record, settlement.state, settlement.cause);
  } catch (const std::exception& error) {
    if (!is_unreadable(attempt->job_id, error)) {
      lock.lock();
      return state_.hold(error.what());
    }
    settlement = {v1::FAILED, error.what()};
    state_.ledger.fail_without_event(record, error.what());
  }
  remove_request(folder);
  if (is_terminal(record.job.state())) remove_run_files(folder);

  lock.lock();
  forget_attempt(*attempt, record, settlement);
  lock.unlock();
  state_.ledger.announce(attempt->job_id);
}

Settlement QueueLoop::decide(const Attempt& attempt, JobRecord& record, AttemptFacts facts) const {
  // No worker was started: the attempt does not count.
  if (!attempt.not_started.empty()) {
    record.job.set_attempts(attempt.number - 1);
    Settlement settlement = settle_stopped(record, attempt.not_started);
    settlement.daemon_lacks = attempt.not_started;
    return settlement;
  }

  try {
    return settle(record, *attempt.log, state_.jobs_directory / attempt.job_id, attempt.exit,
                  std::move(facts));
  } catch (const std::exception& error) {
    if (daemon_lacks(error)) throw;
    add_failure(record.job, v1::Finding::STORAGE, error.what());
    return {v1::FAILED, error.what()};
  }
}

/// @param record  after its settlement
void QueueLoop::forget_attempt(const Attempt& attempt, const JobRecord& record,
                               const Settlement& settlement) {
  v1::Job job = record.job;
  const auto log = attempt.log;
  state_.attempts.count_storage_failure(attempt, settlement, log->content().reached_step);
  state_.attempts.erase(attempt);

  if (job.state() == v1::QUEUED) state_.queue.push(job, attempt.lane);
  if (is_terminal(job.state())) {
    state_.dependents.note_change(job.id());
    log->complete(job);
    views_.learn(job);
    state_.charge(job, milliseconds(now()));
  }

  for (const std::string& lack : {settlement.daemon_lacks, state_.ledger.refusal()})
    if (!lack.empty()) state_.hold(lack);
}

void QueueLoop::hold_if_disk_is_full() {
  {
    const std::lock_guard lock(state_.mutex);
    if (state_.queue_hold.holds() || Clock::now() < disk_checked_ + between_looks_at_disk) return;
  }

  disk_checked_ = Clock::now();
  try {
    require_free_space(state_.jobs_directory, state_.options.minimum_free_bytes);
  } catch (const std::exception& error) {
    const std::lock_guard lock(state_.mutex);
    state_.hold(error.what());
  }
}

void QueueLoop::resume_after_hold() {
  {
    const std::lock_guard lock(state_.mutex);
    if (!state_.queue_hold.holds() || Clock::now() < state_.queue_hold.next_check()) return;
  }

  bool passed = false;
  try {
    require_free_space(state_.jobs_directory, state_.options.minimum_free_bytes);
    probe_directory(state_.jobs_directory);
    state_.store.probe();
    state_.ledger.retry();
    passed = state_.executor.lacks().empty();
  } catch (const std::exception&) {
    // The reason for the hold is known already.
  }

  const std::lock_guard lock(state_.mutex);
  if (!passed) return state_.queue_hold.retry_later();

  log::info("the queue continues; it was held: {}", state_.queue_hold.reason());
  state_.queue_hold.lift();
  state_.changed.notify_all();
}

void QueueLoop::release_dependents() {
  for (;;) {
    std::optional<Dependents::Dependent> dependent;
    {
      const std::lock_guard lock(state_.mutex);
      if (!state_.queue_hold.holds()) dependent = state_.dependents.take_next();
    }
    if (!dependent) return;

    try {
      release_dependent(*dependent);
    } catch (const std::exception& error) {
      if (!daemon_lacks(error)) {
        refuse_start(dependent->id, error);
        continue;
      }
      const std::lock_guard lock(state_.mutex);
      state_.dependents.check_again(dependent->id);
      return state_.hold(error.what());
    }
  }
}

/// Queues a job if all jobs before it have ended as it awaits. Cancels it if one never will.
void QueueLoop::release_dependent(const Dependents::Dependent& dependent) {
  std::string refusal;
  bool waits = false;
  for (const std::string& before : dependent.before) {
    const auto record = state_.ledger.find(before);
    const Awaited awaited = judge(record, dependent.end);
    waits = waits || awaited == Awaited::open;
    if (awaited == Awaited::missed) refusal = describe_miss(before, record, dependent.end);
  }
  if (waits && refusal.empty()) return;

  // Someone may have cancelled it meanwhile.
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, dependent.id);
  if (!state_.dependents.contains(dependent.id)) return;
  lock.unlock();

  auto record = state_.ledger.find(dependent.id);
  if (!record || record->job.state() != v1::QUEUED) return;

  if (!refusal.empty()) {
    requests_.settle_idle(lock, *record, v1::CANCELLED, refusal);
    return;
  }

  const Lane lane = lane_in(state_.jobs_directory / dependent.id);
  lock.lock();
  state_.dependents.remove(dependent.id);
  state_.enqueue_at_its_time(record->job, lane);
}

void QueueLoop::release_begun() {
  const std::lock_guard lock(state_.mutex);
  while (const auto begun = state_.begins.take_begun(milliseconds(now())))
    state_.queue.push(begun->job, begun->lane);
}

/// A casting that is followed runs as long as it is fed or waits: it does not end by itself soon
/// after its owner may feed it no more.
void QueueLoop::end_castings_of_refused_owners() {
  std::vector<v1::Job> castings;
  {
    const std::lock_guard lock(state_.mutex);
    if (!owner_refusal_ || Clock::now() < owners_checked_ + between_checks_of_owners) return;
    owners_checked_ = Clock::now();
    for (const auto& [id, attempt] : state_.attempts.by_job())
      if (attempt->lane == Lane::followed && !attempt->exit && !attempt->kill_at)
        castings.push_back(attempt->record.job);
  }

  for (const v1::Job& job : castings) {
    try {
      const std::string why = owner_refusal_(job);
      if (!why.empty()) requests_.stop(job.id(), {RequestedAction::cancel, why});
    } catch (const std::exception& error) {
      log::error("{}", error.what());
    }
  }
}

bool QueueLoop::may_start() const {
  return !state_.shutting_down && !state_.queue_hold.holds();
}

std::optional<std::string> QueueLoop::next_job() const {
  const bool has_places = state_.attempts.count_in(Lane::job) < state_.executor.capacity();
  return state_.queue.front([&](Lane lane, const std::string& owner) {
    return (lane == Lane::followed || has_places) && state_.bound_reached(lane, owner).empty();
  });
}

/// @return whether there may be another job to start
bool QueueLoop::start_next() {
  std::unique_lock lock(state_.mutex);
  const auto id = may_start() ? next_job() : std::nullopt;
  if (!id) return false;
  const ExclusiveJob job(state_, lock, *id);
  if (!may_start() || next_job() != id) return true;
  lock.unlock();

  try {
    auto [record, log] = begin_attempt(*id);

    lock.lock();
    const Lane lane = state_.queue.lane_of(*id);
    state_.queue.erase(*id);
    if (!log) return true;  // it no longer waits

    state_.queue.charge(record.job.owner(), JobQueue::start_charge_s, milliseconds(now()));

    const auto attempt = state_.attempts.add(std::move(record), std::move(log), lane, false);
    state_.attempts.start(*attempt);
    if (const std::string fault = state_.ledger.refusal(); !fault.empty()) state_.hold(fault);
  } catch (const std::exception& error) {
    refuse_start(*id, error);
    return true;
  }

  lock.unlock();
  state_.ledger.announce(*id);
  return true;
}

/// Records that a job is running. @return no log if the job does not wait
std::pair<JobRecord, std::shared_ptr<EventLog>> QueueLoop::begin_attempt(const std::string& id) {
  require_free_space(state_.jobs_directory, state_.options.minimum_free_bytes);
  auto record = state_.ledger.find(id);
  // RUNNING without a worker: the daemon could not write that it waits again.
  const bool waits =
      record && (record->job.state() == v1::QUEUED || record->job.state() == v1::RUNNING);
  if (!waits) return {};
  const auto folder = state_.jobs_directory / id;
  require_files_to_run(folder, read_job_description(folder));
  auto log = state_.logs.open(id);
  remove_request(folder);  // a crash may have left one

  v1::Job& job = record->job;
  job.set_attempts(job.attempts() + 1);
  if (!job.has_start_time()) *job.mutable_start_time() = now();
  state_.ledger.transition(
      *record, v1::RUNNING,
      job.attempts() == 1 ? "started" : fmt::format("started again (attempt {})", job.attempts()));

  log->announce();
  log->hand_over();
  state_.logs.follow(id);
  return {std::move(*record), std::move(log)};
}

/// Other disk faults are those of a whole file system. A hold ends once the folder of all jobs can
/// be written: one that comes back each time for the same job is of its own files.
bool QueueLoop::is_unreadable(const std::string& id, const std::exception& error) {
  constexpr int most_in_a_row = 3;
  const auto* system = dynamic_cast<const std::system_error*>(&error);
  if (system == nullptr || system->code().value() != EIO) {
    failed_reads_.erase(id);
    return false;
  }
  if (++failed_reads_[id] < most_in_a_row) return false;
  failed_reads_.erase(id);
  return true;
}

/// A job that cannot be started waits for the missing resource; it fails only for its own files.
void QueueLoop::refuse_start(const std::string& id, const std::exception& error) {
  try {
    const auto lack = daemon_lacks(error);
    if (lack && !is_unreadable(id, error)) throw std::runtime_error(*lack);
    auto record = state_.ledger.find(id);
    if (record && record->job.state() == v1::QUEUED) {
      if (lack) {
        state_.ledger.fail_without_event(*record, error.what());
      } else {
        add_failure(record->job, v1::Finding::STORAGE, error.what());
        state_.ledger.settle(*record, v1::FAILED, error.what());
      }
      state_.ledger.announce(id);
    }
    const std::lock_guard lock(state_.mutex);
    state_.dequeue(id);
  } catch (const std::exception& lack) {  // the job is tried again after the hold
    const std::lock_guard lock(state_.mutex);
    state_.hold(lack.what());
  }
}

}  // namespace dccast::jobs
