#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace dccast::studies {

/// Has response surfaces built before they are asked for, on a thread of its own that stands back
/// behind everything else of the daemon.
class SurfaceKeeper {
public:
  /// Builds what the runs of a study allow.
  using Ready = std::function<void(const std::string& study)>;
  explicit SurfaceKeeper(Ready ready);

  /// The study has changed. Does not wait; several calls may lead to one look.
  void look_at(const std::string& study);
  /// Ends once what is being built is built.
  void stop();

private:
  void run(const std::stop_token& stop);
  void build(const std::string& study) const;

  const Ready ready_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> to_look_at_;
  std::jthread thread_;
};

}  // namespace dccast::studies
