#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace dccast::studies {

/// Someone who follows a study. Its call must not block.
class StudyWatcher {
public:
  virtual ~StudyWatcher() = default;
  virtual void on_changed() = 0;
};

/// Wakes the watchers of studies on a thread of its own: soon after a study or any job has changed,
/// and every second while there are watchers, as progress is no change of state.
class StudyNotifier {
public:
  /// @param version  changes whenever jobs have; asked while there are watchers
  explicit StudyNotifier(std::function<std::int64_t()> version);
  ~StudyNotifier();

  /// Calls the watcher soon, and after every change from now on, as long as it lives.
  void watch(const std::string& study, std::weak_ptr<StudyWatcher> watcher);
  void note(const std::string& study);
  /// Calls every watcher once more.
  void wake_all();

private:
  void run(const std::stop_token& stop);
  bool jobs_have_changed();
  /// Those to be called now. Forgets those that are gone.
  std::vector<std::shared_ptr<StudyWatcher>> due(bool all);

  const std::function<std::int64_t()> version_;
  std::int64_t seen_version_ = -1;  ///< of the thread

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> news_;
  std::map<std::string, std::vector<std::weak_ptr<StudyWatcher>>> watchers_;
  std::jthread thread_;
};

}  // namespace dccast::studies
