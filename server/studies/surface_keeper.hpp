#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace dccast::studies {

/// Has response surfaces built before anybody asks: looks at the studies that have not ended, on a
/// thread of its own that stands back behind everything else of the daemon.
class SurfaceKeeper {
public:
  /// Builds what the runs of a study allow so far. @return whether more may come
  using Ready = std::function<bool(const std::string& study)>;
  explicit SurfaceKeeper(Ready ready);

  /// From now on until all its runs have ended.
  void follow(const std::string& study);
  /// Ends once what is being built is built.
  void stop();

private:
  void run(const std::stop_token& stop);
  bool may_get_more(const std::string& study) const;

  const Ready ready_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> followed_;
  std::jthread thread_;
};

}  // namespace dccast::studies
