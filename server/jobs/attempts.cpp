#include "server/jobs/attempts.hpp"

#include <openssl/crypto.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "proto/values/hexadecimal.hpp"
#include "proto/values/sha256.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"

namespace dccast::jobs {

namespace {

constexpr std::size_t token_bytes = 32;  // what a worker proves its identity with

/// From the acknowledgement of a worker's last word to its kill: it only has to leave.
constexpr std::chrono::seconds leaving_time{5};

/// From the end of a worker's process to that of its link, should the link not end by itself.
constexpr std::chrono::seconds last_words_time{2};

/// Whether a worker has the token of an attempt. The token is random, so that its hash needs no
/// salt.
bool knows_token(const Attempt& attempt, const std::string& token) {
  const std::string hash = values::sha256(token);
  return hash.size() == attempt.token_sha256.size() &&
         CRYPTO_memcmp(hash.data(), attempt.token_sha256.data(), hash.size()) == 0;
}

v1::WorkerOrder stop_order(bool checkpoint) {
  v1::WorkerOrder order;
  order.mutable_stop()->set_checkpoint(checkpoint);
  return order;
}

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

void Attempts::order_stop(Attempt& attempt, bool checkpoint) {
  attempt.kill_at = Clock::now() + options_.stop_grace;
  if (attempt.channel)
    attempt.channel->send(stop_order(checkpoint));
  else
    executor_.kill(attempt.job_id, attempt.number);  // it has not called yet: nothing is lost
}

void Attempts::stop_all() {
  shutting_down_ = true;
  for (const auto& [id, attempt] : attempts_)
    if (!attempt->settled) order_stop(*attempt, true);
}

v1::WorkerOrder Attempts::start_order(const Attempt& attempt) const {
  v1::WorkerOrder order;
  auto* start = order.mutable_start();
  const auto complete_case = store_.complete_case(attempt.job_id);
  if (!complete_case || !start->mutable_case_()->ParseFromString(*complete_case))
    throw std::runtime_error("the job store has no readable case of job " + attempt.job_id);
  start->set_directory(options_.jobs_directory / attempt.job_id);
  start->set_resume(attempt.number > 1 || attempt.adopted);
  start->set_last_reported_step(attempt.log->reached_step());
  start->set_heartbeat_interval_s(
      std::chrono::duration<double>(options_.heartbeat_interval).count());
  start->set_other_version(options_.other_version);
  start->set_threads(options_.job_threads);
  return order;
}

/// A case that cannot be read is the daemon's trouble, not the worker's.
v1::WorkerOrder Attempts::order_or_blame(Attempt& attempt) const {
  try {
    return start_order(attempt);
  } catch (const std::exception& error) {
    const std::lock_guard lock(attempt.mutex);
    attempt.storage_error = error.what();
    throw;
  }
}

std::shared_ptr<Attempt> Attempts::attach(const v1::WorkerMessage::Hello& hello,
                                          std::shared_ptr<WorkerChannel> channel) {
  const auto found = attempts_.find(hello.job_id());
  if (found == attempts_.end() || found->second->settled || found->second->channel ||
      !knows_token(*found->second, hello.token())) {
    spdlog::warn("worker link: a caller without a valid token was refused (process {})",
                 hello.process_id());
    return nullptr;
  }
  Attempt& attempt = *found->second;
  const v1::WorkerOrder order = order_or_blame(attempt);
  attempt.channel = std::move(channel);
  {
    const std::lock_guard lock(attempt.mutex);
    attempt.last_word = attempt.last_advance = Clock::now();
  }
  attempt.channel->send(order);  // here, so that no order to stop can come before it
  // What was requested before a restart of the daemon.
  if (attempt.record.requested_action != RequestedAction::none)
    order_stop(attempt, attempt.record.requested_action == RequestedAction::pause);
  return found->second;
}

std::string Attempts::hear(Attempt& attempt, v1::JobEvent event) {
  const std::lock_guard lock(attempt.mutex);
  if (attempt.closed || !attempt.storage_error.empty()) return {};
  if (event.has_step() || event.has_resumed()) attempt.last_advance = Clock::now();
  try {
    attempt.log->append(event);
    return {};
  } catch (const std::exception& failure) {
    // Nothing is written after a hole; the next attempt is told where the log ends.
    return attempt.storage_error = failure.what();
  }
}

void Attempts::note_word(Attempt& attempt) {
  const std::lock_guard lock(attempt.mutex);
  attempt.last_word = Clock::now();
}

void Attempts::note_validity_loss(Attempt& attempt, const v1::ValidityLoss& loss) {
  if (!attempt.settled) *attempt.record.job.mutable_validity_loss() = loss;
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
  if (finished.outcome() == Finished::SUCCEEDED) attempt.record.solver = options_.solver;
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

void Attempts::detach(const std::shared_ptr<Attempt>& attempt) {
  attempt->channel.reset();
  if (attempt->ended) {
    if (find(attempt->job_id, attempt->number) == attempt) conclude(attempt, *attempt->ended);
    return;
  }
  // A worker without a link leaves by itself; one that hangs must not hold the job.
  if (!attempt->settled && !attempt->kill_at)
    attempt->kill_at = Clock::now() + std::chrono::seconds(1);
}

void Attempts::worker_started(const std::string& job_id, int number, const std::string& handle) {
  const auto attempt = find(job_id, number);
  if (!attempt) return;
  attempt->record.worker_handle = handle;
  spdlog::debug("job {}: worker {}", job_id, handle);
  try {
    store_.update(attempt->record, Durability::normal);
  } catch (const StoreError& error) {
    // Only a crash of the daemon would need it, and local workers die with their daemon anyway.
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

void Attempts::kill_hung(Attempt& attempt, const std::string& what) {
  attempt.hung = what;
  attempt.kill_at = Clock::now() + last_words_time;  // tried again should the kill get lost
  spdlog::warn("job {}: its worker {}: killed", attempt.job_id, what);
  executor_.kill(attempt.job_id, attempt.number);
}

void Attempts::kill_overdue(Clock::time_point now) {
  std::vector<std::shared_ptr<Attempt>> overdue;
  for (const auto& [id, attempt] : attempts_) {
    if (attempt->kill_at && now >= *attempt->kill_at) overdue.push_back(attempt);
    if (attempt->settled || attempt->kill_at) continue;
    if (const auto silence = silence_deadline(*attempt, options_.watchdog); now >= silence.at)
      kill_hung(*attempt, silence.what);
  }
  for (const auto& attempt : overdue) {
    attempt->kill_at.reset();
    if (attempt->ended) {
      conclude(attempt, *attempt->ended);
      continue;
    }
    spdlog::warn("job {}: its worker did not leave in time: killed", attempt->job_id);
    executor_.kill(attempt->job_id, attempt->number);
  }
}

Attempts::Clock::time_point Attempts::next_deadline() const {
  Clock::time_point deadline = Clock::now() + std::chrono::hours(1);
  for (const auto& [id, attempt] : attempts_) {
    if (attempt->kill_at)
      deadline = std::min(deadline, *attempt->kill_at);
    else if (!attempt->settled)
      deadline = std::min(deadline, silence_deadline(*attempt, options_.watchdog).at);
  }
  return deadline;
}

void Attempts::forgive_silences(Clock::time_point now) {
  for (const auto& [id, attempt] : attempts_) jobs::forgive_silence(*attempt, now);
}

}  // namespace dccast::jobs
