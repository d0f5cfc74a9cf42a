#include "server/jobs/logs/event_logs.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr std::chrono::milliseconds sync_interval{500};

// All followed files are polled as well: inotify reports changes of local files, but not those made
// by another machine.
constexpr int poll_interval_ms = 100;
constexpr int poll_interval_without_inotify_ms = 10;

// A network file system may show the old size of an open file for up to a minute; opening the file
// makes it ask its server.
constexpr std::chrono::seconds reopen_interval{2};

void set_aside(const std::filesystem::path& path, const std::string& why) {
  const auto aside = free_name(path.string() + ".damaged");
  std::filesystem::rename(path, aside);
  log::warn("{}; moved to {}, the log begins again", why, aside.string());
}

/// Opens a log. If nothing of it is left it begins again, because the description of the job is in
/// another file.
std::shared_ptr<EventLog> open_or_begin(const std::filesystem::path& path) {
  const std::string kind = storage::kind_of_entry(path);
  if (!kind.empty() && kind != storage::regular_file)
    set_aside(path, fmt::format("{} is {}", path.string(), kind));

  try {
    return std::make_shared<EventLog>(path);
  } catch (const NoEventLog& error) {
    set_aside(path, error.what());
    return std::make_shared<EventLog>(path);
  }
}

/// Reads all pending events. @return the watches whose files have changed
std::set<int> read_changes(const storage::FileDescriptor& inotify) {
  std::set<int> changed;
  if (!inotify) return changed;

  alignas(inotify_event) std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t size = ::read(inotify.get(), buffer.data(), buffer.size());
    if (size <= 0) return changed;

    const char* const end = buffer.data() + size;
    for (const char* position = buffer.data(); position < end;) {
      const auto* event = reinterpret_cast<const inotify_event*>(position);
      changed.insert(event->wd);
      position += sizeof *event + event->len;
    }
  }
}

}  // namespace

EventLogs::EventLogs(std::filesystem::path jobs_directory)
    : jobs_directory_(std::move(jobs_directory)),
      changes_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)),
      notifier_([this](const std::stop_token& stop) { run_notifier(stop); }),
      syncer_([this](const std::stop_token& stop) { run_syncer(stop); }),
      follower_([this](const std::stop_token& stop) { run_follower(stop); }) {}

std::shared_ptr<EventLogs::Slot> EventLogs::find_slot(const std::string& job_id) {
  const std::lock_guard lock(logs_mutex_);
  if (const auto found = logs_.find(job_id); found != logs_.end()) return found->second;

  // A slot that only the map holds belongs to a log that no one has open or is opening.
  std::erase_if(logs_, [](const auto& entry) {
    return entry.second.use_count() == 1 && entry.second->log.expired();
  });
  return logs_[job_id] = std::make_shared<Slot>();
}

std::shared_ptr<EventLog> EventLogs::find_open(const std::string& job_id) {
  const std::lock_guard lock(logs_mutex_);
  const auto found = logs_.find(job_id);
  return found == logs_.end() ? nullptr : found->second->log.lock();
}

std::shared_ptr<EventLog> EventLogs::open(const std::string& job_id) {
  const auto slot = find_slot(job_id);
  const std::lock_guard opening(slot->opening);
  if (auto log = find_open(job_id)) return log;

  auto log = open_or_begin(jobs_directory_ / job_id / "events.log");
  log->on_append([this, job_id] { note_appended(job_id); });

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
  if (changes_) followed.watch = ::inotify_add_watch(changes_.get(), path.c_str(), IN_MODIFY);
}

/// Reads what was appended to followed logs, and stops following those that no one holds any more.
/// @param changed  watches of the files to read; empty: all files
/// @param reopen   open each of them once more
void EventLogs::refresh_followed(const std::set<int>& changed, bool reopen) {
  std::vector<std::string> jobs;
  {
    const std::lock_guard lock(mutex_);
    for (const Followed& followed : followed_)
      if (changed.empty() || changed.contains(followed.watch)) jobs.push_back(followed.job_id);
  }

  for (const std::string& job_id : jobs) {
    const std::shared_ptr<EventLog> log = find_open(job_id);
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
      if (followed.watch >= 0) ::inotify_rm_watch(changes_.get(), followed.watch);
      return true;
    });
  }
}

void EventLogs::run_follower(const std::stop_token& stop) {
  const int interval_ms = changes_ ? poll_interval_ms : poll_interval_without_inotify_ms;
  auto last_poll = std::chrono::steady_clock::now();
  auto last_reopened = last_poll;

  while (!stop.stop_requested()) {
    pollfd waiting{changes_.get(), POLLIN, 0};
    ::poll(&waiting, changes_ ? 1 : 0, interval_ms);
    const std::set<int> changed = read_changes(changes_);
    if (!changed.empty()) refresh_followed(changed, false);

    const auto now = std::chrono::steady_clock::now();
    if (now - last_poll < std::chrono::milliseconds(interval_ms)) continue;
    last_poll = now;

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

void EventLogs::note_appended(const std::string& job_id) {
  {
    const std::lock_guard lock(mutex_);
    to_sync_.insert(job_id);
    if (!watchers_.contains(job_id) || !to_notify_.insert(job_id).second) return;
  }
  changed_.notify_all();
}

/// Watchers of ended jobs are never notified again, so they are dropped when a new one comes.
void EventLogs::drop_expired() {
  for (auto& [job_id, watchers] : watchers_)
    std::erase_if(watchers, [](const auto& watcher) { return watcher.expired(); });
  std::erase_if(watchers_, [](const auto& entry) { return entry.second.empty(); });
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

    // Without the lock: a watcher may call this object.
    for (const auto& watcher : alive) watcher->on_appended();
  }
}

void EventLogs::run_syncer(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    // Shows workers that a daemon is running.
    ::utimensat(AT_FDCWD, daemon_file(jobs_directory_).c_str(), nullptr, 0);

    std::set<std::string> jobs;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, sync_interval, [] { return false; });
      jobs.swap(to_sync_);
    }

    for (const std::string& job_id : jobs) {
      // A log that is no longer open was synced when it was closed.
      const std::shared_ptr<EventLog> log = find_open(job_id);
      try {
        if (log) log->sync();
      } catch (const std::system_error& error) {
        log::error("job {}: {}", job_id, error.what());
      }
    }
  }
}

}  // namespace dccast::jobs
