#pragma once

#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/storage/file.hpp"
#include "server/jobs/logs/event_log.hpp"

namespace dccast::jobs {

/// Follows an event log. The call must not block; the watcher reads with its own cursor.
class Watcher {
public:
  virtual ~Watcher() = default;
  /// Called from the notifier's thread; must not block.
  virtual void on_appended() = 0;
};

/// The open event logs; each file is opened once. Notifies watchers on a separate thread, so that a
/// writer never waits for a watcher. Syncs appended events to disk about every 0.5 s. Follows the
/// files that workers append to.
class EventLogs {
public:
  /// @param jobs_directory  holds one folder per job
  explicit EventLogs(std::filesystem::path jobs_directory);

  /// The log of a job, opened if it is not open yet. Reading a long file does not delay calls for
  /// the logs of other jobs. @throws as EventLog's constructor
  std::shared_ptr<EventLog> open(const std::string& job_id);

  /// Calls the watcher soon, and after every further event of the job while the watcher lives.
  void watch(const std::string& job_id, std::weak_ptr<Watcher> watcher);

  /// Reads what the worker of a job appends, while anyone else holds the log.
  void follow(const std::string& job_id);

  /// Calls every watcher, because something other than a log has changed.
  void wake_all();

private:
  /// Entry for the log of one job.
  struct Slot {
    std::mutex opening;           ///< held by the thread that opens the file
    std::weak_ptr<EventLog> log;  ///< guarded by logs_mutex_
  };

  /// The slot of a job, made if there is none.
  std::shared_ptr<Slot> find_slot(const std::string& job_id);
  /// The log of a job if it is open; null otherwise.
  std::shared_ptr<EventLog> find_open(const std::string& job_id);
  /// Remembers that watchers of a job are to be woken and its log is to be synced.
  void note_appended(const std::string& job_id);
  /// Wakes watchers.
  void run_notifier(const std::stop_token& stop);
  /// Syncs logs, so that no caller waits for the disk.
  void run_syncer(const std::stop_token& stop);
  /// Follows logs to which a worker of its own appends.
  void run_follower(const std::stop_token& stop);
  /// Reads on in followed logs.
  /// @param changed  watches of the files to read; empty: all files
  /// @param reopen   open each of them once more
  void refresh_followed(const std::set<int>& changed, bool reopen);
  /// Drops watchers of ended jobs, which are never notified again.
  void drop_expired();

  std::filesystem::path jobs_directory_;
  std::mutex logs_mutex_;
  std::map<std::string, std::shared_ptr<Slot>> logs_;
  std::mutex mutex_;  ///< guards all below
  std::condition_variable_any changed_;
  std::set<std::string> to_notify_;
  std::set<std::string> to_sync_;
  std::map<std::string, std::vector<std::weak_ptr<Watcher>>> watchers_;  ///< by job
  /// A log that a worker appends to.
  struct Followed {
    std::string job_id;
    int watch = -1;  ///< inotify watch on its file; -1: none, the file is polled
  };
  storage::FileDescriptor changes_;  ///< inotify; empty if the system has none left
  std::vector<Followed> followed_;
  std::jthread notifier_;
  std::jthread syncer_;
  std::jthread follower_;
};

}  // namespace dccast::jobs
