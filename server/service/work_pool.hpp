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

/// Bound on work that was posted and has not begun.
struct WaitingBound {
  /// Pieces of work that may wait.
  std::size_t number = SIZE_MAX;
  std::size_t bytes = SIZE_MAX;  ///< a single item may be larger if nothing else waits
};

/// A few threads for calls that wait for the disk or compute: gRPC's own threads must not block.
class WorkPool {
public:
  /// The destructor first does the work that was posted.
  WorkPool(int threads, const WaitingBound& bound);
  /// One thread does its work in the order of posting. Exceptions of work are logged.
  /// @param bytes  memory held by the work [bytes]
  /// @return       false if too much is waiting: the work was not accepted
  bool post(std::function<void()> work, std::size_t bytes = 0);

private:
  /// A piece of work and the memory that it holds while it waits.
  struct Work {
    std::function<void()> work;
    std::size_t bytes = 0;
  };

  /// The loop of a thread: runs work in the order in which it was posted.
  void run(const std::stop_token& stop);

  const WaitingBound bound_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Work> waiting_;
  std::size_t waiting_bytes_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace dccast::service
