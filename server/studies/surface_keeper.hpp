#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace dccast::studies {

/// Builds response surfaces in advance, on a thread with a lower priority than the rest of the
/// daemon.
class SurfaceKeeper {
public:
  /// Builds the surfaces of a study that its runs permit.
  using Build = std::function<void(const std::string& study)>;

  /// Starts the thread. @param build  called from it; outlives it
  void start(Build build);
  /// Ends the thread after the surface being built.
  void stop();
  /// Schedules a study whose runs have changed. Does not wait; several calls may cause one build.
  void look_at(const std::string& study);

private:
  /// The thread: builds the surfaces of each scheduled study, one after the other.
  void run(const std::stop_token& stop);
  /// Builds the surfaces of a study; a failure is logged, as the next request builds them anyway.
  void build(const std::string& study) const;

  Build build_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> to_look_at_;
  std::jthread thread_;
};

}  // namespace dccast::studies
