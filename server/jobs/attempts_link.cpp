// What the attempts say to their workers and hear of them over the link.
#include <openssl/crypto.h>

#include <stdexcept>
#include <utility>

#include "proto/values/sha256.hpp"
#include "server/jobs/attempts.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/worker_claim.hpp"

namespace dccast::jobs {

namespace {

/// Reports that a worker keeps, at the most, when it is not time for a heartbeat.
constexpr std::int64_t most_unacknowledged = 256;

/// Whether a worker has the token of an attempt. The token is random, so that its hash needs no
/// salt.
bool knows_token(const Attempt& attempt, const std::string& token) {
  const std::string hash = values::sha256(token);
  return hash.size() == attempt.token_sha256.size() &&
         CRYPTO_memcmp(hash.data(), attempt.token_sha256.data(), hash.size()) == 0;
}

/// Whether a daemon that has started, or found, the worker of an attempt waits for this call.
bool is_awaited(const Attempt& attempt, const v1::WorkerMessage::Hello& hello) {
  if (attempt.settled || attempt.called || !knows_token(attempt, hello.token())) return false;
  return !hello.running() || (attempt.adopted && hello.protocol() == worker_protocol);
}

v1::WorkerOrder stop_order(bool checkpoint) {
  v1::WorkerOrder order;
  order.mutable_stop()->set_checkpoint(checkpoint);
  return order;
}

}  // namespace

void Attempts::order_stop(Attempt& attempt, bool checkpoint) {
  attempt.kill_at = Clock::now() + options_.stop_grace;
  if (attempt.channel)
    attempt.channel->send(stop_order(checkpoint));
  else if (!attempt.adopted || attempt.called)
    executor_.kill(attempt.job_id, attempt.number);  // it has not called yet: nothing is lost
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
  start->set_attempt(attempt.number);
  start->set_daemon_patience_s(std::chrono::duration<double>(options_.daemon_patience).count());
  start->set_reports_stored(attempt.log->attempt_reports().value_or(0));
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

/// The attempt that waits for this caller; null for none.
std::shared_ptr<Attempt> Attempts::expected(const v1::WorkerMessage::Hello& hello) const {
  const auto found = attempts_.find(hello.job_id());
  return found != attempts_.end() && is_awaited(*found->second, hello) ? found->second : nullptr;
}

std::shared_ptr<Attempt> Attempts::attach(const v1::WorkerMessage::Hello& hello,
                                          std::shared_ptr<WorkerChannel> channel) {
  const auto awaited = expected(hello);
  if (!awaited) {
    spdlog::warn("worker link: a caller that no attempt waits for was refused (process {})",
                 hello.process_id());
    return nullptr;
  }
  Attempt& attempt = *awaited;
  const v1::WorkerOrder order = order_or_blame(attempt);
  attempt.channel = std::move(channel);
  attempt.called = true;
  attempt.solver = hello.solver();
  {
    const std::lock_guard lock(attempt.mutex);
    attempt.last_word = attempt.last_advance = Clock::now();
  }
  attempt.channel->send(order);  // here, so that no order to stop can come before it
  // What was requested before a restart of the daemon, or before a worker that ran on has called.
  if (attempt.record.requested_action != RequestedAction::none || shutting_down_)
    order_stop(attempt, attempt.record.requested_action != RequestedAction::cancel);
  return awaited;
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

std::optional<v1::WorkerOrder> Attempts::acknowledgement(Attempt& attempt, bool beat) const {
  if (options_.daemon_patience.count() == 0) return std::nullopt;  // its worker keeps nothing
  const auto stored = attempt.log->attempt_reports();
  const std::lock_guard lock(attempt.mutex);
  const std::int64_t news = stored.value_or(0) - attempt.acknowledged_reports;
  const bool no_beat_will_come = options_.heartbeat_interval.count() == 0;
  if (news <= 0 || (!beat && !no_beat_will_come && news < most_unacknowledged)) return std::nullopt;
  attempt.acknowledged_reports = *stored;
  v1::WorkerOrder order;
  order.mutable_stored()->set_reports(*stored);
  return order;
}

void Attempts::note_word(Attempt& attempt) {
  const std::lock_guard lock(attempt.mutex);
  attempt.last_word = Clock::now();
}

void Attempts::note_validity_loss(Attempt& attempt, const v1::ValidityLoss& loss) {
  if (!attempt.settled) *attempt.record.job.mutable_validity_loss() = loss;
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

}  // namespace dccast::jobs
