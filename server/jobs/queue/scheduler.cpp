#include "server/jobs/queue/scheduler.hpp"

#include "server/jobs/folder/events.hpp"
#include "server/jobs/queue/recovery.hpp"

namespace dccast::jobs {

Scheduler::Scheduler(SchedulerOptions options, JobStore& store, EventLogs& logs, Executor& executor)
    : state_(std::move(options), store, logs, executor),
      views_(state_),
      submissions_(state_, views_),
      requests_(state_, views_),
      loop_(state_, views_, requests_) {
  // Reports of the executor come from its own thread.
  const auto report_to = [this](auto function) {
    return [this, function](const std::string& job_id, int number, const auto& report) {
      const std::lock_guard lock(state_.mutex);
      (state_.attempts.*function)(job_id, number, report);
      state_.changed.notify_all();
    };
  };

  executor.set_calls({.not_started = report_to(&Attempts::worker_not_started),
                      .ended = report_to(&Attempts::worker_ended),
                      .waits = report_to(&Attempts::worker_waits),
                      .stopped = report_to(&Attempts::worker_stopped)});
}

void Scheduler::recover() {
  Recovery(state_, views_).run();
}

void Scheduler::start() {
  state_.executor.end_adoption();
  loop_.start();
}

std::optional<v1::Job> Scheduler::find(const std::string& id) {
  auto record = state_.ledger.find(id);
  if (!record) return std::nullopt;
  const std::lock_guard lock(state_.mutex);
  return views_.view(std::move(*record));
}

std::shared_ptr<EventLog> Scheduler::log(const std::string& id) {
  auto log = state_.logs.open(id);
  const auto lacks_its_end = [&] {
    if (log->terminal_event()) return false;
    const auto record = state_.store.find(id);
    return record && is_terminal(record->job.state()) && !log->terminal_event();
  };
  if (!lacks_its_end()) return log;

  // The end is being announced, or the file was damaged since; watchers must see an end in either
  // case.
  std::unique_lock lock(state_.mutex);
  const ExclusiveJob job(state_, lock, id);
  lock.unlock();
  if (!lacks_its_end()) return log;

  v1::JobEvent event =
      state_event(state_.ledger.find(id).value(), "ended; part of the event log is lost");
  log->append(event);
  return log;
}

std::vector<v1::Job> Scheduler::list(const JobStore::Page& page) {
  std::vector<JobRecord> records = state_.store.list(page);
  for (JobRecord& record : records) record = state_.ledger.present(std::move(record));

  std::vector<v1::Job> jobs;
  const std::lock_guard lock(state_.mutex);
  for (JobRecord& record : records) jobs.push_back(views_.view(std::move(record)));
  return jobs;
}

bool Scheduler::is_awaited(const std::string& id) {
  const std::lock_guard lock(state_.mutex);
  return state_.dependents.is_awaited(id);
}

int Scheduler::queued() {
  const std::lock_guard lock(state_.mutex);
  return state_.waiting();
}

int Scheduler::running() {
  const std::lock_guard lock(state_.mutex);
  return state_.attempts.running();
}

std::string Scheduler::held() {
  const std::lock_guard lock(state_.mutex);
  return state_.queue_hold.reason();
}

}  // namespace dccast::jobs
