#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace dccast::service {

/// A few threads for calls that wait for the disk or compute: gRPC's own threads must not.
class WorkPool {
public:
  /// @param maximum_waiting  of what was posted and nobody has begun
  explicit WorkPool(int threads, std::size_t maximum_waiting = SIZE_MAX);
  /// Does what was posted, then ends.
  ~WorkPool();
  /// With one thread, work is done in the order it was posted. What it throws is logged.
  /// @return false when too much is waiting: the work was not taken
  bool post(std::function<void()> work);

private:
  void run();

  const std::size_t maximum_waiting_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace dccast::service
