#include "server/jobs/queue/attempts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "dccast/v1/worker.pb.h"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/jobs/queue/queue_hold.hpp"

namespace dccast::jobs {

namespace {

/// Interval at which a kill is repeated, in case it is lost.
constexpr std::chrono::seconds between_kills{2};

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// Begin of an attempt. For attempts of an earlier daemon it is known only for the first one.
Attempt::Clock::time_point begin_time(const Attempt& attempt) {
  const auto now_at = Attempt::Clock::now();
  if (!attempt.adopted || attempt.number > 1) return now_at;

  return now_at - std::chrono::milliseconds(std::max<std::int64_t>(
                      0, milliseconds(now()) - milliseconds(attempt.record.job.start_time())));
}

/// Restarts the timers of a worker, because the daemon itself was suspended and missed heartbeats.
void forgive_silence(Attempt& attempt, Attempt::Clock::time_point now) {
  attempt.looked = attempt.last_sign = attempt.last_progress = now;
}

/// Looks for new heartbeats: the time of the claim on the folder, and the events of the log.
void update_heartbeats(Attempt& attempt, const std::filesystem::path& folder,
                       Attempt::Clock::time_point now) {
  attempt.looked = now;

  const std::int64_t sign = signs_in(folder).claimed_ns;
  if (std::exchange(attempt.sign, sign) != sign) {
    if (!std::exchange(attempt.begun, true)) attempt.last_progress = now;
    attempt.last_sign = now;
  }

  const std::int64_t sequence = attempt.log->last_sequence();
  if (std::exchange(attempt.sequence, sequence) != sequence)
    attempt.last_sign = attempt.last_progress = now;
}

/// The first moment at which the worker of an attempt will have been silent for too long.
struct SilenceDeadline {
  Attempt::Clock::time_point at;
  std::string fault;  ///< what the worker will have failed to do by then
};

SilenceDeadline silence_deadline(const Attempt& attempt, const WatchdogLimits& limits) {
  if (!attempt.begun)
    return {attempt.last_sign + limits.hello,
            fmt::format("did not begin within {:g} s of its start", seconds(limits.hello))};

  const SilenceDeadline heartbeat{
      attempt.last_sign + limits.heartbeat,
      fmt::format("gave no sign of life for {:g} s", seconds(limits.heartbeat))};
  if (limits.stall.count() == 0 || attempt.lane == Lane::followed) return heartbeat;

  const SilenceDeadline stall{
      attempt.last_progress + limits.stall,
      fmt::format("was alive but made no step for {:g} s", seconds(limits.stall))};

  return heartbeat.at <= stall.at ? heartbeat : stall;
}

/// When a job that follows a casting will have had no reading for too long.
Attempt::Clock::time_point reading_deadline(const Attempt& attempt, const WatchdogLimits& limits) {
  if (attempt.lane != Lane::followed || !attempt.begun || limits.reading().count() == 0)
    return Attempt::Clock::time_point::max();
  return attempt.last_progress + limits.reading();
}

/// Shifts the timers of an attempt by the time for which its worker was stopped.
void shift_timers(Attempt& attempt, Attempt::Clock::duration stopped) {
  using TimePoint = Attempt::Clock::time_point;
  for (TimePoint* time :
       {&attempt.since, &attempt.looked, &attempt.last_sign, &attempt.last_progress})
    *time += stopped;

  if (attempt.time_limit_at != TimePoint::max()) attempt.time_limit_at += stopped;
  if (attempt.kill_at) *attempt.kill_at += stopped;
}

/// Time of the next check for heartbeats.
Attempt::Clock::time_point next_check(const Attempt& attempt, const WatchdogLimits& limits) {
  auto shortest = std::min(limits.hello, limits.heartbeat);
  if (limits.stall.count() > 0) shortest = std::min(shortest, limits.stall);
  return attempt.looked + std::max(shortest / 4, std::chrono::milliseconds(1));
}

/// Why nothing can be written into the folder of a job now; empty if it can.
std::string find_storage_error(const std::filesystem::path& folder, const WorkerExit& exit) {
  try {
    probe_directory(folder);
  } catch (const std::system_error& error) {
    if (daemon_lacks(error)) return error.what();
  }

  if (exit.code != exit_storage) return {};
  return fmt::format("its worker could not write into {} (see worker.log there)", folder.string());
}

bool has_storage_failure(const v1::RunEnd& end) {
  const auto is_of_storage = [](const v1::Finding& failure) {
    return failure.kind() == v1::Finding::STORAGE;
  };
  return is_of_storage(end.failure()) ||
         std::ranges::any_of(end.failure().further(), is_of_storage);
}

/// What is damaged of the files of a job itself, so that no other job is concerned; empty if
/// nothing is, or if the folder of all jobs cannot be used.
std::string find_damage(const std::filesystem::path& folder) {
  try {
    probe_directory(folder.parent_path());
  } catch (const std::system_error&) {
    return {};
  }

  try {
    require_files_to_run(folder, read_job_description(folder));
    if (follows_readings(folder)) ReadingsReader(folder).read_new();
    return {};
  } catch (const std::exception& error) {
    return daemon_lacks(error) ? "" : error.what();
  }
}

}  // namespace

double ran_s(const Attempt& attempt, Attempt::Clock::time_point now) {
  if (!attempt.stopped_for.empty()) now = attempt.stopped_at;
  return attempt.record.job.run_s() + std::chrono::duration<double>(now - attempt.since).count();
}

Settlement settle(JobRecord& record, EventLog& log, const std::filesystem::path& folder,
                  const std::optional<WorkerExit>& exit, AttemptFacts facts) {
  log.refresh();

  const EventLogContent content = log.content();
  facts.reached_step = content.reached_step;
  if (content.last_step) facts.reached_time = content.last_step->time_s();

  if (const auto request = read_request(folder)) {
    record.requested_action = request->action;
    record.request_reason = request->reason;
  }

  // The worker has recorded the end of its run: the exit of its process does not matter.
  if (const auto& end = content.run_end; end && end->attempt() == record.job.attempts()) {
    facts.missing_artifact = missing_artifact(folder, *end);
    if (end->outcome() == v1::RunEnd::OTHER_VERSION_FOUND) set_checkpoint_aside(folder);
    if (has_storage_failure(*end)) facts.damage = find_damage(folder);
    if (end->outcome() == v1::RunEnd::SUCCEEDED) record.solver = end->solver();
    // scancel lets a worker stop at a checkpoint first.
    const bool was_stopped = end->outcome() == v1::RunEnd::STOPPED;
    if (was_stopped && exit && exit->cancelled) return settle_lost(record, *exit, facts);
    return settle_run_end(record, *end, facts);
  }

  if (!exit)
    return settle_stopped(record,
                          "dccastd was restarted; the job continues from its last checkpoint");

  facts.storage_error = find_storage_error(folder, *exit);
  if (!facts.storage_error.empty()) facts.damage = find_damage(folder);
  return settle_lost(record, *exit, facts);
}

Attempts::Attempts(AttemptOptions options, Executor& executor)
    : options_(std::move(options)), executor_(executor) {}

std::filesystem::path Attempts::folder(const Attempt& attempt) const {
  return options_.jobs_directory / attempt.job_id;
}

std::shared_ptr<Attempt> Attempts::add(JobRecord record, std::shared_ptr<EventLog> log, Lane lane,
                                       bool adopted) {
  auto attempt = std::make_shared<Attempt>();
  attempt->job_id = record.job.id();
  attempt->number = record.job.attempts();
  attempt->adopted = attempt->begun = adopted;
  attempt->lane = lane;

  attempt->sequence = log->last_sequence();
  attempt->log = std::move(log);
  attempt->record = std::move(record);
  attempt->sign = signs_in(folder(*attempt)).claimed_ns;

  forgive_silence(*attempt, Clock::now());
  start_timer(*attempt, begin_time(*attempt));

  if (const auto early = ended_unknown_.find({attempt->job_id, attempt->number});
      adopted && early != ended_unknown_.end())
    attempt->exit = early->second;

  return attempts_[attempt->job_id] = attempt;
}

void Attempts::start_timer(Attempt& attempt, Clock::time_point since) {
  attempt.since = since;

  double limit_s = attempt.record.job.time_limit_s();
  if (limit_s <= 0.0 || (options_.maximum_time_s > 0.0 && options_.maximum_time_s < limit_s))
    limit_s = options_.maximum_time_s;
  if (limit_s <= 0.0) return;

  const std::chrono::duration<double> left(limit_s - attempt.record.job.run_s());
  attempt.time_limit_at = since + std::chrono::duration_cast<Clock::duration>(left);
}

WorkerLaunch Attempts::make_launch(const Attempt& attempt) const {
  WorkerLaunch launch{attempt.job_id, attempt.number, folder(attempt), make_order(attempt)};

  launch.estimated_s = attempt.record.job.estimated_s();
  if (attempt.lane != Lane::job) launch.urgency = classify_query(launch.estimated_s, false);
  launch.order.set_nice(nice_value(launch.urgency));

  return launch;
}

v1::SolveCase Attempts::make_order(const Attempt& attempt) const {
  v1::SolveCase order;
  order.set_job_id(attempt.job_id);
  order.set_attempt(attempt.number);
  order.set_directory(folder(attempt));

  order.set_resume(attempt.number > 1);
  order.set_other_version(options_.other_version);

  const bool goes_first = attempt.lane != Lane::job;
  order.set_threads(goes_first ? options_.first_threads : options_.job_threads);
  order.set_goes_first(goes_first);

  order.set_heartbeat_interval_s(seconds(options_.heartbeat_interval));
  order.set_daemon_patience_s(seconds(options_.daemon_patience));
  order.set_memory_bytes(options_.worker_memory_bytes);
  order.set_file_bytes(options_.worker_file_bytes);

  return order;
}

void Attempts::start(Attempt& attempt) {
  try {
    executor_.start(make_launch(attempt));
  } catch (const std::exception& error) {
    worker_not_started(attempt.job_id, attempt.number, error.what());
  }
  if (shutting_down_) stop(attempt);
}

std::shared_ptr<Attempt> Attempts::find(const std::string& job_id) const {
  const auto found = attempts_.find(job_id);
  return found == attempts_.end() ? nullptr : found->second;
}

std::vector<std::shared_ptr<Attempt>> Attempts::ended() const {
  std::vector<std::shared_ptr<Attempt>> ended;
  for (const auto& [id, attempt] : attempts_)
    if (attempt->exit) ended.push_back(attempt);
  return ended;
}

void Attempts::expect_stop(Attempt& attempt) {
  attempt.kill_at = Clock::now() + options_.stop_grace;
}

void Attempts::stop(Attempt& attempt) {
  expect_stop(attempt);
  executor_.stop(attempt.job_id, attempt.number);
}

void Attempts::stop_all() {
  shutting_down_ = true;
  for (const auto& [id, attempt] : attempts_)
    if (!attempt->exit) stop(*attempt);
}

void Attempts::worker_not_started(const std::string& job_id, int number, const std::string& why) {
  worker_ended(job_id, number, {why});
  if (const auto attempt = find(job_id); attempt && attempt->number == number)
    attempt->not_started = why;
}

void Attempts::worker_waits(const std::string& job_id, int number, const std::string& why) {
  const auto attempt = find(job_id);
  if (!attempt || attempt->number != number) return;

  attempt->waits = why;
  start_timer(*attempt, Clock::now());
  if (!why.empty()) forgive_silence(*attempt, Clock::now());
}

void Attempts::worker_stopped(const std::string& job_id, int number, const std::string& why) {
  const auto attempt = find(job_id);
  if (!attempt || attempt->number != number) return;

  const auto now = Clock::now();
  const bool was_stopped = !attempt->stopped_for.empty();
  if (was_stopped) shift_timers(*attempt, now - attempt->stopped_at);

  attempt->stopped_for = why;
  attempt->stopped_at = now;
}

void Attempts::worker_ended(const std::string& job_id, int number, const WorkerExit& exit) {
  const auto attempt = find(job_id);
  if (attempt && attempt->number == number)
    attempt->exit = exit;
  else if (recovering_)
    ended_unknown_[{job_id, number}] = exit;
}

void Attempts::end_recovery() {
  recovering_ = false;
  ended_unknown_.clear();
}

AttemptFacts Attempts::facts(const Attempt& attempt) const {
  AttemptFacts facts{.shutting_down = shutting_down_,
                     .worker_restarts = options_.worker_restarts,
                     .other_version = options_.other_version,
                     .hung = attempt.hung,
                     .over_time = attempt.over_time,
                     .unfed = attempt.unfed};

  if (const auto failures = storage_failures_.find(attempt.job_id);
      failures != storage_failures_.end())
    facts.storage_failures = failures->second.in_a_row;
  return facts;
}

void Attempts::count_storage_failure(const Attempt& attempt, const Settlement& settlement,
                                     std::int64_t reached_step) {
  if (settlement.daemon_lacks.empty()) {
    storage_failures_.erase(attempt.job_id);
    return;
  }

  StorageFailures& failures = storage_failures_[attempt.job_id];
  failures.in_a_row = reached_step > failures.reached_step ? 1 : failures.in_a_row + 1;
  failures.reached_step = reached_step;
}

void Attempts::kill_overdue(Clock::time_point now) {
  const auto kill = [&](Attempt& attempt, const std::string& why) {
    attempt.kill_at = now + between_kills;
    log::warn("job {}: killing its worker, which {}", attempt.job_id, why);
    executor_.kill(attempt.job_id, attempt.number);
  };

  for (const auto& [id, attempt] : attempts_) {
    if (attempt->exit || !attempt->stopped_for.empty()) continue;

    if (attempt->kill_at) {
      if (now >= *attempt->kill_at) kill(*attempt, "did not leave in time");
      continue;
    }

    if (now >= attempt->time_limit_at && attempt->waits.empty()) {
      attempt->over_time = fmt::format("it has run for {:.0f} s", ran_s(*attempt, now));
      log::info("job {}: stopping it at its time limit: {}", id, attempt->over_time);
      stop(*attempt);
      continue;
    }

    if (now >= next_check(*attempt, options_.watchdog))
      update_heartbeats(*attempt, folder(*attempt), now);

    if (now >= reading_deadline(*attempt, options_.watchdog)) {
      attempt->unfed =
          fmt::format("no reading has come for {:g} s", seconds(options_.watchdog.reading()));
      log::info("job {}: stopping it: {}", id, attempt->unfed);
      stop(*attempt);
      continue;
    }

    if (const auto silence = silence_deadline(*attempt, options_.watchdog); now >= silence.at) {
      attempt->hung = silence.fault;
      kill(*attempt, silence.fault);
    }
  }
}

Attempts::Clock::time_point Attempts::next_deadline() const {
  Clock::time_point deadline = Clock::now() + std::chrono::hours(1);
  for (const auto& [id, attempt] : attempts_) {
    if (attempt->exit || !attempt->stopped_for.empty()) continue;

    if (attempt->kill_at)
      deadline = std::min(deadline, *attempt->kill_at);
    else
      deadline =
          std::min({deadline, attempt->time_limit_at, next_check(*attempt, options_.watchdog),
                    reading_deadline(*attempt, options_.watchdog),
                    silence_deadline(*attempt, options_.watchdog).at});
  }

  return deadline;
}

void Attempts::forgive_silences(Clock::time_point now) {
  for (const auto& [id, attempt] : attempts_) forgive_silence(*attempt, now);
}

}  // namespace dccast::jobs
