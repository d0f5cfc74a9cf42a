#include "server/jobs/logs/event_logs.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>
#include "server/jobs/log.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"

namespace dccast::jobs {

namespace {

constexpr std::chrono::milliseconds sync_interval{500};

// From one look at all followed files to the next: the system reports changes of local files, not
// of those that another machine writes.
constexpr int look_interval_ms = 100;
constexpr int look_interval_without_reports_ms = 10;

// Opening a file makes a network file system ask its server how long it is by now; an open one it
// answers for from memory, for up to a minute.
constexpr std::chrono::seconds reopen_interval{2};

}  // namespace

EventLogs::EventLogs(std::filesystem::path jobs_directory)
    : jobs_directory_(std::move(jobs_directory)),
      changes_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)),
      notifier_([this](const std::stop_token& stop) { run_notifier(stop); }),
      syncer_([this](const std::stop_token& stop) { run_syncer(stop); }),
      follower_([this](const std::stop_token& stop) { run_follower(stop); }) {}

std::shared_ptr<EventLogs::Slot> EventLogs::slot_of(const std::string& job_id) {
  const std::lock_guard lock(logs_mutex_);
  if (const auto found = logs_.find(job_id); found != logs_.end()) return found->second;
  // A slot that only the map holds is of a log that no one has open or is about to open.
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

namespace {

void set_aside(const std::filesystem::path& path, const std::string& why) {
  const auto aside = free_name(path.string() + ".damaged");
  std::filesystem::rename(path, aside);
  log::warn("{}; it begins again, and is now {}", why, aside.string());
}

/// What a job is, its folder says in another file: a log of which nothing is left begins again.
std::shared_ptr<EventLog> opened(const std::filesystem::path& path) {
  const std::string kind = storage::kind_of_entry(path);
  if (!kind.empty() && kind != storage::regular_file)
    set_aside(path, path.string() + " is " + kind);

  try {
    return std::make_shared<EventLog>(path);
  } catch (const NoEventLog& error) {
    set_aside(path, error.what());
    return std::make_shared<EventLog>(path);
  }
}

}  // namespace

std::shared_ptr<EventLog> EventLogs::open(const std::string& job_id) {
  const auto slot = slot_of(job_id);
  const std::lock_guard opening(slot->opening);
  if (auto log = open_now(job_id)) return log;
  auto log = opened(jobs_directory_ / job_id / "events.log");
  log->on_append([this, job_id] { mark(job_id); });
  const std::lock_guard lock(logs_mutex_);
  slot->log = log;
  return log;
}

void EventLogs::watch(const std::string& job_id, std::weak_ptr<Watcher> watcher) {
  const std::lock_guard lock(mutex_);
  drop_expired();
  watchers_[job_id].push_back(std::move(watcher));
  to_notify_.insert(job_id);
  changed_.notify_all();
}

void EventLogs::follow(const std::string& job_id) {
  const auto path = jobs_directory_ / job_id / "events.log";
  const std::lock_guard lock(mutex_);
  Followed& followed = followed_.emplace_back(Followed{.job_id = job_id});
  if (changes_) followed.mark = ::inotify_add_watch(changes_.get(), path.c_str(), IN_MODIFY);
}

/// @param marked  marks of the files that have changed; empty: look at all
/// @param reopen  open each of them once more
void EventLogs::refresh_followed(const std::set<int>& marked, bool reopen) {
  std::vector<std::string> jobs;
  {
    const std::lock_guard lock(mutex_);
    for (const Followed& followed : followed_)
      if (marked.empty() || marked.contains(followed.mark)) jobs.push_back(followed.job_id);
  }
  for (const std::string& job_id : jobs) {
    const std::shared_ptr<EventLog> log = open_now(job_id);
    try {
      if (log && reopen) storage::File(jobs_directory_ / job_id / "events.log", O_RDONLY);
      if (log) log->refresh();
    } catch (const std::exception& error) {
      log::error("job {}: {}", job_id, error.what());
    }
    if (log) continue;
    const std::lock_guard lock(mutex_);
    std::erase_if(followed_, [&](const Followed& followed) {
      if (followed.job_id != job_id) return false;
      if (followed.mark >= 0) ::inotify_rm_watch(changes_.get(), followed.mark);
      return true;
    });
  }
}

void EventLogs::run_follower(const std::stop_token& stop) {
  alignas(inotify_event) std::array<char, 4096> buffer;
  auto last_look = std::chrono::steady_clock::now();
  auto last_reopened = last_look;
  while (!stop.stop_requested()) {
    const int interval_ms = changes_ ? look_interval_ms : look_interval_without_reports_ms;
    pollfd waiting{changes_.get(), POLLIN, 0};
    ::poll(&waiting, changes_ ? 1 : 0, interval_ms);
    std::set<int> marked;
    for (ssize_t got; changes_ && (got = ::read(changes_.get(), buffer.data(), buffer.size())) > 0;)
      for (const char* at = buffer.data(); at < buffer.data() + got;) {
        const auto* event = reinterpret_cast<const inotify_event*>(at);
        marked.insert(event->wd);
        at += sizeof *event + event->len;
      }
    if (!marked.empty()) refresh_followed(marked, false);
    const auto now = std::chrono::steady_clock::now();
    if (now - last_look < std::chrono::milliseconds(interval_ms)) continue;
    last_look = now;
    const bool reopen = now - last_reopened >= reopen_interval;
    if (reopen) last_reopened = now;
    refresh_followed({}, reopen);
  }
}

void EventLogs::wake_all() {
  const std::lock_guard lock(mutex_);
  for (const auto& [job_id, watchers] : watchers_) to_notify_.insert(job_id);
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

/// Those of jobs that have ended are notified of nothing, where they could be dropped.
void EventLogs::drop_expired() {
  for (auto at = watchers_.begin(); at != watchers_.end();) {
    std::erase_if(at->second, [](const auto& watcher) { return watcher.expired(); });
    at = at->second.empty() ? watchers_.erase(at) : std::next(at);
  }
}

void EventLogs::run_notifier(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<std::shared_ptr<Watcher>> alive;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !to_notify_.empty(); })) return;
      const std::string job_id = *to_notify_.begin();
      to_notify_.erase(to_notify_.begin());
      if (const auto found = watchers_.find(job_id); found != watchers_.end())
        for (const auto& watcher : found->second)
          if (auto held = watcher.lock()) alive.push_back(std::move(held));
    }
    for (const auto& watcher : alive) watcher->on_appended();
  }
}

void EventLogs::run_syncer(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    ::utimensat(AT_FDCWD, daemon_file(jobs_directory_).c_str(), nullptr, 0);
    std::set<std::string> jobs;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, sync_interval, [] { return false; });
      jobs.swap(to_sync_);
    }
    for (const std::string& job_id : jobs) {
      // A log that no one holds any more has ended (and was synced then) or its job was requeued;
      // opening it again would be for the disk's sake only.
      const std::shared_ptr<EventLog> log = open_now(job_id);
      try {
        if (log) log->sync();
      } catch (const std::system_error& error) {
        log::error("job {}: {}", job_id, error.what());
      }
    }
  }
}

}  // namespace dccast::jobs
