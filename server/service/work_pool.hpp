#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace dccast::service {

/// A few threads for calls that wait for the disk or compute: gRPC's own threads must not.
class WorkPool {
public:
  explicit WorkPool(int threads);
  /// Does what was posted, then ends.
  ~WorkPool();
  /// With one thread, work is done in the order it was posted.
  void post(std::function<void()> work);

private:
  void run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace dccast::service
