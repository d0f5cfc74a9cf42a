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

/// Threads for unary calls, by what a call waits for: one that takes long holds up only its like.
struct Lanes {
  /// @param checkers         checks at once
  /// @param query_workers    queries at once
  /// @param maximum_waiting  beyond those, of each; further ones are refused
  Lanes(int checkers, int query_workers, int maximum_waiting)
      : few{.number = static_cast<std::size_t>(maximum_waiting), .bytes = many.bytes},
        checks(checkers, few),
        queries(query_workers, few) {}

  static constexpr WaitingBound many{.number = 3000, .bytes = 64'000'000};  ///< for each lane
  const WaitingBound few;

  WorkPool status{4, many};     ///< one look into the store
  WorkPool histories{2, many};  ///< reads event logs
  WorkPool durable{4, many};    ///< syncs new jobs and requests to disk
  WorkPool checks;              ///< asks a worker; one thread for each that may be at work
  WorkPool queries;             ///< from the check of a case to the end of its run; likewise
};

}  // namespace dccast::service
