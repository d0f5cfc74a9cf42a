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

/// How much may wait: of what was posted and is not begun.
struct WaitingBound {
  std::size_t number = SIZE_MAX;
  std::size_t bytes = SIZE_MAX;  ///< one piece of work may be larger when nothing else waits
};

/// A few threads for calls that wait for the disk or compute: gRPC's own threads must not.
class WorkPool {
public:
  /// Its end does what was posted first.
  WorkPool(int threads, const WaitingBound& bound);
  /// With one thread, work is done in the order it was posted. What it throws is logged.
  /// @param bytes  that it keeps in memory
  /// @return       false when too much is waiting: the work was not taken
  bool post(std::function<void()> work, std::size_t bytes = 0);

private:
  struct Work {
    std::function<void()> work;
    std::size_t bytes = 0;
  };

  void run(const std::stop_token& stop);

  const WaitingBound bound_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Work> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace dccast::service
