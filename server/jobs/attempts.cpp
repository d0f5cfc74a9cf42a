#include "server/jobs/attempts.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "proto/values/hexadecimal.hpp"
#include "proto/values/sha256.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr std::size_t token_bytes = 32;  // what a worker proves its identity with

/// From the acknowledgement of a worker's last word to its kill: it only has to leave.
constexpr std::chrono::seconds leaving_time{5};

std::string start_cause(int number) {
  return number == 1 ? "started" : "started again (attempt " + std::to_string(number) + ")";
}

void close(Attempt& attempt) {
  const std::lock_guard lock(attempt.mutex);
  attempt.closed = true;
}

}  // namespace

Attempts::Attempts(AttemptOptions options, JobStore& store, EventLogs& logs, Ledger& ledger,
                   Executor& executor)
    : options_(std::move(options)),
      store_(store),
      logs_(logs),
      ledger_(ledger),
      executor_(executor) {}

std::shared_ptr<Attempt> Attempts::add(JobRecord record, std::shared_ptr<EventLog> log) {
  auto attempt = std::make_shared<Attempt>();
  attempt->job_id = record.job.id();
  attempt->number = record.job.attempts();
  attempt->token_sha256 = record.worker_token_sha256;
  attempt->log = std::move(log);
  attempt->begun = Clock::now();
  attempt->record = std::move(record);
  return attempts_[attempt->job_id] = attempt;
}

void Attempts::begin(JobRecord record) {
  const std::string token = values::random_hexadecimal(token_bytes);
  auto log = logs_.open(record.job.id());
  record.job.set_attempts(record.job.attempts() + 1);
  if (!record.job.has_start_time())
    *record.job.mutable_start_time() = timestamp(milliseconds(now()));
  record.worker_handle.clear();
  record.worker_token_sha256 = values::sha256(token);
  ledger_.transition(record, v1::RUNNING, start_cause(record.job.attempts()));
  const auto attempt = add(std::move(record), std::move(log));
  try {
    executor_.start(
        {attempt->job_id, attempt->number, token, options_.jobs_directory / attempt->job_id});
  } catch (const std::exception& error) {
    withdraw(attempt, error.what());
  }
}

void Attempts::adopt(JobRecord record) {
  const v1::JobState state = record.job.state();
  // Of a job that does not run nothing is heard any more, and its log may be damaged.
  auto log = state == v1::RUNNING ? logs_.open(record.job.id()) : nullptr;
  const auto attempt = add(std::move(record), std::move(log));
  attempt->adopted = true;
  if (state == v1::RUNNING) return;
  attempt->settled = true;
  attempt->requeue = state == v1::QUEUED;
  attempt->kill_at = Clock::now() + last_words_time;  // tried again should the kill get lost
  executor_.kill(attempt->job_id, attempt->number);
}

/// The worker was not even started: the job waits as if this attempt had not been.
void Attempts::withdraw(const std::shared_ptr<Attempt>& attempt, const std::string& why) {
  JobRecord& record = attempt->record;
  record.job.set_attempts(attempt->number - 1);
  settle(*attempt, settle_stopped(record, why));
  if (news_.daemon_lacks.empty()) news_.daemon_lacks = why;
  conclude(attempt, why);
}

int Attempts::running() const {
  return static_cast<int>(
      std::ranges::count_if(attempts_, [](const auto& entry) { return !entry.second->settled; }));
}

Attempt* Attempts::running(const std::string& job_id) {
  const auto found = attempts_.find(job_id);
  if (found == attempts_.end() || found->second->settled) return nullptr;
  found->second->log->tell(found->second->record.job);
  return found->second.get();
}

Attempt* Attempts::leaving(const std::string& job_id) {
  const auto found = attempts_.find(job_id);
  return found != attempts_.end() && found->second->settled ? found->second.get() : nullptr;
}

std::shared_ptr<Attempt> Attempts::find(const std::string& job_id, int number) const {
  const auto found = attempts_.find(job_id);
  return found != attempts_.end() && found->second->number == number ? found->second : nullptr;
}

void Attempts::request(Attempt& attempt, RequestedAction action, const std::string& reason) {
  JobRecord next = attempt.record;
  next.requested_action = action;
  next.request_reason = reason;
  store_.update(next, Durability::full);
  attempt.record = std::move(next);
  order_stop(attempt, action == RequestedAction::pause);
}

void Attempts::stop_all() {
  shutting_down_ = true;
  for (const auto& [id, attempt] : attempts_)
    if (!attempt->settled) order_stop(*attempt, true);
}

AttemptFacts Attempts::facts_of(Attempt& attempt) const {
  AttemptFacts facts{.shutting_down = shutting_down_,
                     .worker_restarts = options_.worker_restarts,
                     .other_version = options_.other_version,
                     .hung = attempt.hung};
  if (const auto failures = storage_failures_.find(attempt.job_id);
      failures != storage_failures_.end())
    facts.storage_failures = failures->second.in_a_row;
  facts.reached_step = attempt.log->reached_step();
  if (const auto step = attempt.log->last_step()) facts.reached_time = step->time_s();
  const std::lock_guard lock(attempt.mutex);
  facts.storage_error = attempt.storage_error;
  return facts;
}

void Attempts::finish(Attempt& attempt, const Finished& finished) {
  if (attempt.settled) return;
  close(attempt);
  AttemptFacts facts = facts_of(attempt);
  if (finished.outcome() == Finished::SUCCEEDED)
    facts.missing_artifact = missing_artifact(attempt, finished);
  if (finished.outcome() == Finished::OTHER_VERSION_FOUND)
    set_checkpoint_aside(options_.jobs_directory / attempt.job_id);
  if (finished.outcome() == Finished::SUCCEEDED)
    attempt.record.solver = attempt.solver.empty() ? options_.solver : attempt.solver;
  settle(attempt, settle_finished(attempt.record, finished, facts));
  attempt.kill_at = Clock::now() + leaving_time;
  v1::WorkerOrder acknowledged;
  acknowledged.mutable_acknowledged();
  if (attempt.channel) attempt.channel->send(acknowledged);
}

void Attempts::settle(Attempt& attempt, const Settlement& settlement) {
  attempt.settled = true;
  attempt.record.worker_handle.clear();
  attempt.record.worker_token_sha256.clear();
  const std::string error = ledger_.settle(attempt.record, settlement.state, settlement.cause);
  attempt.requeue = attempt.record.job.state() == v1::QUEUED;
  count_storage_failure(attempt, settlement);
  for (const std::string& lack : {settlement.daemon_lacks, error})
    if (news_.daemon_lacks.empty()) news_.daemon_lacks = lack;
}

void Attempts::count_storage_failure(Attempt& attempt, const Settlement& settlement) {
  if (settlement.daemon_lacks.empty()) {
    storage_failures_.erase(attempt.job_id);
    return;
  }
  const std::int64_t reached = facts_of(attempt).reached_step;
  StorageFailures& failures = storage_failures_[attempt.job_id];
  failures.in_a_row = reached > failures.reached_step ? 1 : failures.in_a_row + 1;
  failures.reached_step = reached;
}

std::string Attempts::missing_artifact(const Attempt& attempt, const Finished& finished) const {
  for (const v1::Artifact& artifact : finished.artifacts()) {
    std::error_code error;
    const auto size = std::filesystem::file_size(
        options_.jobs_directory / attempt.job_id / artifact.name(), error);
    if (error) return "result " + artifact.name() + " is not there: " + error.message();
    if (static_cast<std::int64_t>(size) != artifact.size_bytes())
      return "result " + artifact.name() + " has not the size its worker wrote";
  }
  return {};
}

void Attempts::worker_started(const std::string& job_id, int number, const std::string& handle) {
  const auto attempt = find(job_id, number);
  if (!attempt) return;
  attempt->record.worker_handle = handle;
  spdlog::debug("job {}: worker {}", job_id, handle);
  try {
    store_.update(attempt->record, Durability::normal);
  } catch (const StoreError& error) {
    // Only the next daemon would need it, and it finds a local worker by its claim, too.
    spdlog::error("job {}: {}", job_id, error.what());
  }
}

void Attempts::worker_not_started(const std::string& job_id, int number, const std::string& why) {
  if (const auto attempt = find(job_id, number)) withdraw(attempt, why);
}

void Attempts::worker_ended(const std::string& job_id, int number, const std::string& how) {
  const auto attempt = find(job_id, number);
  if (!attempt) return;
  // What it said last may still be on its way; the link ends after that, as its process is gone.
  if (!attempt->channel || attempt->settled) return conclude(attempt, how);
  attempt->ended = how;
  attempt->kill_at = Clock::now() + last_words_time;
}

void Attempts::conclude(const std::shared_ptr<Attempt>& attempt, const std::string& how) {
  close(*attempt);
  if (!attempt->settled) settle(*attempt, settle_lost(attempt->record, how, facts_of(*attempt)));
  attempts_.erase(attempt->job_id);
  const v1::Job& job = attempt->record.job;
  if (attempt->requeue && job.state() == v1::QUEUED) news_.requeued.push_back(job);
  if (!is_terminal(job.state())) return;
  storage_failures_.erase(attempt->job_id);
  remove_run_files(options_.jobs_directory / attempt->job_id);
}

}  // namespace dccast::jobs
