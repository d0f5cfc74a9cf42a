#include "server/jobs/event_logs.hpp"

#include <chrono>
#include <system_error>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr std::chrono::milliseconds sync_interval{500};

}  // namespace

EventLogs::EventLogs(std::filesystem::path jobs_directory)
    : jobs_directory_(std::move(jobs_directory)),
      notifier_([this](const std::stop_token& stop) { run_notifier(stop); }),
      syncer_([this](const std::stop_token& stop) { run_syncer(stop); }) {}

EventLogs::~EventLogs() = default;

std::shared_ptr<EventLogs::Slot> EventLogs::slot_of(const std::string& job_id) {
  const std::lock_guard lock(logs_mutex_);
  if (const auto found = logs_.find(job_id); found != logs_.end()) return found->second;
  // A slot that only the map holds is of a log that nobody has open or is about to open.
  std::erase_if(logs_, [](const auto& entry) {
    return entry.second.use_count() == 1 && entry.second->log.expired();
  });
  return logs_[job_id] = std::make_shared<Slot>();
}

std::shared_ptr<EventLog> EventLogs::open_now(const std::string& job_id) {
  const std::lock_guard lock(logs_mutex_);
  const auto found = logs_.find(job_id);
  return found == logs_.end() ? nullptr : found->second->log.lock();
}

std::shared_ptr<EventLog> EventLogs::open(const std::string& job_id) {
  const auto slot = slot_of(job_id);
  const std::lock_guard opening(slot->opening);
  if (auto log = open_now(job_id)) return log;
  auto log = std::make_shared<EventLog>(jobs_directory_ / job_id / "events.log");
  log->on_append([this, job_id] { mark(job_id); });
  const std::lock_guard lock(logs_mutex_);
  slot->log = log;
  return log;
}

void EventLogs::watch(const std::string& job_id, std::weak_ptr<Watcher> watcher) {
  {
    const std::lock_guard lock(mutex_);
    watchers_[job_id].push_back(std::move(watcher));
    to_notify_.insert(job_id);
  }
  changed_.notify_all();
}

void EventLogs::wake_all() {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [job_id, watchers] : watchers_) to_notify_.insert(job_id);
  }
  changed_.notify_all();
}

void EventLogs::mark(const std::string& job_id) {
  {
    const std::lock_guard lock(mutex_);
    to_sync_.insert(job_id);
    if (!watchers_.contains(job_id) || !to_notify_.insert(job_id).second) return;
  }
  changed_.notify_all();
}

std::vector<std::shared_ptr<Watcher>> EventLogs::watchers_of(const std::string& job_id) {
  const auto found = watchers_.find(job_id);
  if (found == watchers_.end()) return {};
  std::erase_if(found->second, [](const auto& watcher) { return watcher.expired(); });
  std::vector<std::shared_ptr<Watcher>> alive;
  for (const auto& watcher : found->second)
    if (auto held = watcher.lock()) alive.push_back(std::move(held));
  if (found->second.empty()) watchers_.erase(found);
  return alive;
}

void EventLogs::run_notifier(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<std::shared_ptr<Watcher>> alive;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !to_notify_.empty(); })) return;
      const std::string job_id = *to_notify_.begin();
      to_notify_.erase(to_notify_.begin());
      alive = watchers_of(job_id);
    }
    for (const auto& watcher : alive) watcher->on_appended();
  }
}

void EventLogs::run_syncer(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::set<std::string> jobs;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, sync_interval, [] { return false; });
      jobs.swap(to_sync_);
    }
    for (const std::string& job_id : jobs) {
      // A log that nobody holds any more has ended (and was synced then) or its job was requeued;
      // opening it again would be for the disk's sake only.
      const std::shared_ptr<EventLog> log = open_now(job_id);
      try {
        if (log) log->sync();
      } catch (const std::system_error& error) {
        spdlog::error("job {}: {}", job_id, error.what());
      }
    }
  }
}

}  // namespace dccast::jobs
