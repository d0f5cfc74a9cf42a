// What the scheduler does with workers: start them, hear them, stop them, settle what they leave.
#include <openssl/crypto.h>
#include <spdlog/spdlog.h>

#include <system_error>
#include <utility>
#include <vector>

#include "proto/values/hexadecimal.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

namespace {

constexpr std::size_t token_bytes = 32;  // what a worker proves its identity with

/// From the acknowledgement of a worker's last word to its kill: it only has to leave.
constexpr std::chrono::seconds leaving_time{5};

/// From the end of a worker's process to that of its link, should the link not end by itself.
constexpr std::chrono::seconds last_words_time{2};

bool same_token(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

v1::WorkerOrder stop_order(bool checkpoint) {
  v1::WorkerOrder order;
  order.mutable_stop()->set_checkpoint(checkpoint);
  return order;
}

void set_failure(v1::Job& job, v1::Failure::Kind kind, const std::string& message) {
  if (job.has_failure()) return;  // the first cause is kept
  job.mutable_failure()->set_kind(kind);
  job.mutable_failure()->set_message(message);
}

std::string cancel_cause(const JobRecord& record) {
  return record.wish_reason.empty() ? "cancelled by request" : "cancelled: " + record.wish_reason;
}

void close(Run& run) {
  const std::lock_guard lock(run.mutex);
  run.closed = true;
}

std::string storage_error_of(Run& run) {
  const std::lock_guard lock(run.mutex);
  return run.storage_error;
}

}  // namespace

void Scheduler::start_next() {
  while (!shutting_down_ && static_cast<int>(runs_.size()) < options_.workers) {
    const auto id = queue_.pop();
    if (!id) return;
    if (auto record = store_.find(*id)) start_run(std::move(*record));
  }
}

void Scheduler::start_run(JobRecord record) {
  v1::Job& job = record.job;
  job.set_attempts(job.attempts() + 1);
  if (!job.has_start_time()) *job.mutable_start_time() = timestamp(milliseconds(now()));
  record.worker = {};
  try {
    auto run = std::make_shared<Run>();
    run->job_id = job.id();
    run->attempt = job.attempts();
    run->token = values::random_hexadecimal(token_bytes);
    run->log = logs_.open(job.id());
    transition(record, v1::RUNNING,
               job.attempts() == 1
                   ? "started"
                   : "started again (attempt " + std::to_string(job.attempts()) + ")");
    run->record = std::move(record);
    runs_[run->job_id] = run;
    executor_.start({run->job_id, run->attempt, run->token, options_.jobs_directory / run->job_id});
  } catch (const std::exception& error) {
    set_failure(job, v1::Failure::STORAGE, error.what());
    settle(record, v1::FAILED, error.what());
  }
}

void Scheduler::order_stop(Run& run, bool checkpoint) {
  run.kill_at = Clock::now() + options_.stop_grace;
  if (run.channel)
    run.channel->send(stop_order(checkpoint));
  else
    executor_.kill(run.job_id, run.attempt);  // it has not called yet: nothing is lost
  changed_.notify_all();
}

void Scheduler::kill_overdue() {
  std::vector<std::shared_ptr<Run>> overdue;
  for (const auto& [id, run] : runs_)
    if (run->kill_at && Clock::now() >= *run->kill_at) overdue.push_back(run);
  for (const auto& run : overdue) {
    run->kill_at.reset();
    if (run->ended) {
      conclude(run, *run->ended);
      continue;
    }
    spdlog::warn("job {}: its worker did not leave in time: killed", run->job_id);
    executor_.kill(run->job_id, run->attempt);
  }
}

Reply Scheduler::cancel(const std::string& id, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end() || found->second->settled) {
    auto stored = store_.find(id);
    if (!stored) return {Reply::Kind::not_found, {}};
    if (is_terminal(stored->job.state()) || unsettled_.contains(id))
      return {Reply::Kind::done, view(*stored)};
    queue_.erase(id);
    stored->wish_reason = reason;
    transition(*stored, v1::CANCELLED, cancel_cause(*stored));
    if (found != runs_.end()) {
      found->second->requeue = false;
      found->second->record = *stored;
    }
    return {Reply::Kind::done, view(*stored)};
  }
  Run& run = *found->second;
  if (run.record.wish != Wish::cancel) {
    run.record.wish = Wish::cancel;
    run.record.wish_reason = reason;
    store_.update(run.record, Durability::full);
    spdlog::info("job {}: {}; its worker is asked to stop", id, cancel_cause(run.record));
    order_stop(run, false);
  }
  return {Reply::Kind::done, view(*active_record(id))};
}

Reply Scheduler::pause(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end() || found->second->settled) {
    auto stored = store_.find(id);
    if (!stored) return {Reply::Kind::not_found, {}};
    if (is_terminal(stored->job.state()) || unsettled_.contains(id))
      return {Reply::Kind::wrong_state, view(*stored)};
    if (stored->job.state() == v1::PAUSED) return {Reply::Kind::done, view(*stored)};
    queue_.erase(id);
    transition(*stored, v1::PAUSED, "paused by request");
    if (found != runs_.end()) {
      found->second->requeue = false;
      found->second->record = *stored;
    }
    return {Reply::Kind::done, view(*stored)};
  }
  Run& run = *found->second;
  if (run.record.wish == Wish::none) {
    run.record.wish = Wish::pause;
    store_.update(run.record, Durability::full);
    spdlog::info("job {}: pause asked for; its worker goes on to a checkpoint", id);
    order_stop(run, true);
  }
  return {Reply::Kind::done, view(*active_record(id))};
}

std::shared_ptr<Run> Scheduler::attach(const v1::WorkerMessage::Hello& hello,
                                       std::shared_ptr<WorkerChannel> channel) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(hello.job_id());
  if (found == runs_.end() || found->second->channel ||
      !same_token(found->second->token, hello.token())) {
    spdlog::warn("worker link: a caller without a valid token was refused (process {})",
                 hello.process_id());
    return nullptr;
  }
  Run& run = *found->second;
  v1::WorkerOrder order;
  auto* start = order.mutable_start();
  const auto complete_case = store_.complete_case(run.job_id);
  if (!complete_case || !start->mutable_case_()->ParseFromString(*complete_case)) return nullptr;
  start->set_directory(options_.jobs_directory / run.job_id);
  start->set_resume(run.attempt > 1);
  run.channel = std::move(channel);
  run.channel->send(order);  // here, so that no order to stop can come before it
  return found->second;
}

void Scheduler::append(Run& run, v1::JobEvent event) {
  std::string error;
  {
    const std::lock_guard lock(run.mutex);
    if (run.closed) return;
    try {
      run.log->append(event);
      return;
    } catch (const std::exception& failure) {
      if (!run.storage_error.empty()) return;
      error = run.storage_error = failure.what();
    }
  }
  spdlog::error("job {}: {}; its worker is asked to stop", run.job_id, error);
  const std::lock_guard lock(mutex_);
  if (!run.settled) order_stop(run, true);
}

void Scheduler::report(const std::shared_ptr<Run>& run, const v1::WorkerMessage& message) {
  v1::JobEvent event;
  switch (message.what_case()) {
    case v1::WorkerMessage::kStep:
      *event.mutable_step() = message.step();
      return append(*run, std::move(event));
    case v1::WorkerMessage::kMessage:
      *event.mutable_message() = message.message();
      return append(*run, std::move(event));
    case v1::WorkerMessage::kResumed:
      spdlog::info("job {}: resumed from the checkpoint of step {}", run->job_id,
                   message.resumed().step());
      *event.mutable_resumed() = message.resumed();
      return append(*run, std::move(event));
    case v1::WorkerMessage::kFinished: {
      const std::lock_guard lock(mutex_);
      return finish(*run, message.finished());
    }
    case v1::WorkerMessage::kHello:
    case v1::WorkerMessage::WHAT_NOT_SET:
      spdlog::warn("job {}: its worker sent a message out of turn", run->job_id);
  }
}

void Scheduler::detach(const std::shared_ptr<Run>& run) {
  const std::lock_guard lock(mutex_);
  run->channel.reset();
  if (run->ended) {
    const auto found = runs_.find(run->job_id);
    if (found != runs_.end() && found->second == run) conclude(run, *run->ended);
    return;
  }
  // A worker without a link leaves by itself; one that hangs must not hold the job.
  if (!run->settled && !run->kill_at) run->kill_at = Clock::now() + std::chrono::seconds(1);
  changed_.notify_all();
}

void Scheduler::finish(Run& run, const v1::WorkerMessage::Finished& finished) {
  if (run.settled) return;
  close(run);
  v1::Job& job = run.record.job;
  using Finished = v1::WorkerMessage::Finished;
  if (const std::string error = storage_error_of(run); !error.empty()) {
    settle_lost(run, error);
  } else if (finished.outcome() == Finished::SUCCEEDED) {
    *job.mutable_artifacts() = finished.artifacts();
    const std::string missing = missing_artifact(run);
    if (!missing.empty()) set_failure(job, v1::Failure::STORAGE, missing);
    settle(run.record, missing.empty() ? v1::SUCCEEDED : v1::FAILED,
           missing.empty() ? "finished" : missing);
  } else if (finished.outcome() == Finished::FAILED) {
    *job.mutable_failure() = finished.failure();
    *job.mutable_artifacts() = finished.artifacts();
    settle(run.record, v1::FAILED, finished.failure().message());
  } else {
    settle_stopped(run, shutting_down_ ? "dccastd is shutting down; stopped at a checkpoint"
                                       : "its worker was told to leave; stopped at a checkpoint");
  }
  run.settled = true;
  run.kill_at = Clock::now() + leaving_time;
  v1::WorkerOrder acknowledged;
  acknowledged.mutable_acknowledged();
  if (run.channel) run.channel->send(acknowledged);
  changed_.notify_all();
}

std::string Scheduler::missing_artifact(const Run& run) const {
  for (const v1::Artifact& artifact : run.record.job.artifacts()) {
    std::error_code error;
    const auto size =
        std::filesystem::file_size(options_.jobs_directory / run.job_id / artifact.name(), error);
    if (error) return "result " + artifact.name() + " is not there: " + error.message();
    if (static_cast<std::int64_t>(size) != artifact.size_bytes())
      return "result " + artifact.name() + " has not the size its worker wrote";
  }
  return {};
}

void Scheduler::settle_stopped(Run& run, const std::string& cause) {
  const Wish wish = std::exchange(run.record.wish, Wish::none);
  run.record.worker = {};
  if (wish == Wish::cancel) return settle(run.record, v1::CANCELLED, cancel_cause(run.record));
  if (wish == Wish::pause) return settle(run.record, v1::PAUSED, "paused by request");
  run.requeue = true;
  settle(run.record, v1::QUEUED, cause);
}

void Scheduler::settle_lost(Run& run, const std::string& how) {
  JobRecord& record = run.record;
  if (const std::string error = storage_error_of(run); !error.empty()) {
    set_failure(record.job, v1::Failure::STORAGE, error);
    return settle(record, v1::FAILED, error);
  }
  if (record.wish != Wish::none || shutting_down_)
    return settle_stopped(run, "dccastd is shutting down; its worker was killed");
  const auto step = run.log->last_step();
  const std::int64_t reached = step ? step->step() : 0;
  const std::string loss = "worker died with " + how + " after step " + std::to_string(reached);
  if (record.losses++ == 0) record.first_loss = loss;
  const bool same_step = record.lost_step == reached;
  record.lost_step = reached;
  if (record.losses <= options_.worker_restarts)
    return settle_stopped(run, loss + "; restart " + std::to_string(record.losses) + " of " +
                                   std::to_string(options_.worker_restarts));
  std::string message = record.first_loss;
  if (record.losses > 1) message += "; in all it died " + std::to_string(record.losses) + " times";
  if (same_step) message += ", twice in the step after " + std::to_string(reached);
  set_failure(record.job, v1::Failure::WORKER_LOST, message);
  if (step) record.job.mutable_failure()->set_time_s(step->time_s());
  settle(record, v1::FAILED, message);
}

void Scheduler::worker_started(const std::string& job_id, int attempt, ProcessIdentity worker) {
  const std::lock_guard lock(mutex_);
  const auto run = runs_.find(job_id);
  if (run == runs_.end() || run->second->attempt != attempt) return;
  run->second->record.worker = worker;
  spdlog::debug("job {}: worker process {}", job_id, worker.id);
  try {
    store_.update(run->second->record, Durability::normal);
  } catch (const StoreError& error) {
    // Only a crash of the daemon would need it, and workers die with their daemon anyway.
    spdlog::error("job {}: {}", job_id, error.what());
  }
}

void Scheduler::worker_ended(const std::string& job_id, int attempt, const std::string& how) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(job_id);
  if (found == runs_.end() || found->second->attempt != attempt) return;
  // What it said last may still be on its way; the link ends after that, as its process is gone.
  const std::shared_ptr<Run> run = found->second;
  if (!run->channel || run->settled) return conclude(run, how);
  run->ended = how;
  run->kill_at = Clock::now() + last_words_time;
  changed_.notify_all();
}

void Scheduler::conclude(const std::shared_ptr<Run>& run, const std::string& how) {
  close(*run);
  if (!run->settled) {
    run->settled = true;
    settle_lost(*run, how);
  }
  runs_.erase(run->job_id);
  if (run->requeue && run->record.job.state() == v1::QUEUED) queue_.push(run->record.job);
  changed_.notify_all();
}

}  // namespace dccast::jobs
