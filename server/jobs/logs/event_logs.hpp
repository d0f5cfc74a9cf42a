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

/// Someone who follows an event log. Its call must not block: it reads with its own cursor.
class Watcher {
public:
  virtual ~Watcher() = default;
  virtual void on_appended() = 0;
};

/// The open event logs: each file is open once. Wakes watchers on a thread of its
/// own, so that a writer never waits for a watcher; syncs appended events to disk about every
/// 0.5 s; follows the files that workers append to.
class EventLogs {
public:
  /// @param jobs_directory  with one folder per job
  explicit EventLogs(std::filesystem::path jobs_directory);

  /// The log of a job, opened if it is not open. Reading a long file delays no call for another
  /// job's log. @throws as EventLog's constructor
  std::shared_ptr<EventLog> open(const std::string& job_id);

  /// Calls the watcher soon, and after every event of the job from now on, as long as it lives.
  void watch(const std::string& job_id, std::weak_ptr<Watcher> watcher);

  /// Takes what the worker of a job appends, as it happens, as long as somebody else holds the log.
  void follow(const std::string& job_id);

  /// Calls every watcher once more: something else than a log has changed.
  void wake_all();

private:
  /// Where the log of one job is kept while somebody holds it.
  struct Slot {
    std::mutex opening;           ///< one thread opens the file, others wait for it
    std::weak_ptr<EventLog> log;  ///< of logs_mutex_
  };

  std::shared_ptr<Slot> slot_of(const std::string& job_id);
  std::shared_ptr<EventLog> open_now(const std::string& job_id);
  void mark(const std::string& job_id);
  void run_notifier(const std::stop_token& stop);
  void run_syncer(const std::stop_token& stop);
  void run_follower(const std::stop_token& stop);
  void refresh_followed(const std::set<int>& marked, bool reopen);
  void drop_expired();

  std::filesystem::path jobs_directory_;
  std::mutex logs_mutex_;
  std::map<std::string, std::shared_ptr<Slot>> logs_;
  std::mutex mutex_;  ///< of all below
  std::condition_variable_any changed_;
  std::set<std::string> to_notify_;
  std::set<std::string> to_sync_;
  std::map<std::string, std::vector<std::weak_ptr<Watcher>>> watchers_;  ///< by job
  /// A log that a worker appends to.
  struct Followed {
    std::string job_id;
    int mark = -1;  ///< of the system on its file; -1: none, it is looked at now and then
  };
  storage::FileDescriptor changes_;  ///< inotify; nothing where the system has none left
  std::vector<Followed> followed_;
  std::jthread notifier_;
  std::jthread syncer_;
  std::jthread follower_;
};

}  // namespace dccast::jobs
