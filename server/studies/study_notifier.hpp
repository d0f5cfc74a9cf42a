#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace dccast::studies {

/// A listener that follows a study. Its call must not block.
class StudyWatcher {
public:
  virtual ~StudyWatcher() = default;
  /// Called from the notifier's thread after a change; progress alone counts once per interval.
  virtual void on_changed() = 0;
};

/// Wakes watchers of studies on its own thread: soon after a change, at most 20 times a second, and
/// every second while there are watchers, because progress of a run changes no state.
class StudyNotifier {
public:
  StudyNotifier();

  /// Calls the watcher soon, and after every later change, as long as it lives.
  void watch(const std::string& study, std::weak_ptr<StudyWatcher> watcher);
  /// Reports a change of the study. Does not wait.
  void note(const std::string& study);
  /// Calls every watcher once more.
  void wake_all();

private:
  /// The thread: wakes the watchers of studies that have changed.
  void run(const std::stop_token& stop);
  /// Watchers to call now. Drops those that no longer exist.
  std::vector<std::shared_ptr<StudyWatcher>> due(bool every_study);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::set<std::string> changed_studies_;  ///< since the last call of watchers
  std::map<std::string, std::vector<std::weak_ptr<StudyWatcher>>> watchers_;
  std::jthread thread_;
};

}  // namespace dccast::studies
