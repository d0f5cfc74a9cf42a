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
  virtual void on_changed() = 0;
};

/// Wakes the watchers of studies on a thread of its own: soon after a study has changed, no more
/// often than 20 times a second, and every second while there are watchers, as the progress of a
/// run is no change of state.
class StudyNotifier {
public:
  StudyNotifier();

  /// Calls the watcher soon, and after every change from now on, as long as it lives.
  void watch(const std::string& study, std::weak_ptr<StudyWatcher> watcher);
  /// The study has changed. Does not wait.
  void note(const std::string& study);
  /// Calls every watcher once more.
  void wake_all();

private:
  void run(const std::stop_token& stop);
  /// Those to be called now. Forgets those that are gone.
  std::vector<std::shared_ptr<StudyWatcher>> due(bool all);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::set<std::string> changed_studies_;  ///< since watchers were woken
  std::map<std::string, std::vector<std::weak_ptr<StudyWatcher>>> watchers_;
  std::jthread thread_;
};

}  // namespace dccast::studies
