#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <mutex>

#include "server/jobs/executors/precedence.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// What a query waits for before it runs: the queries of its urgency that are before it.
struct QueryWait {
  int running = 0;
  int ahead = 0;            ///< that wait too
  double expected_s = 0.0;  ///< until it begins, from the estimates of these queries [s]
};

/// The runs of queries. Each urgency has threads of its own, so that a query waits for no other one
/// than those of its urgency. Safe to use from several threads.
class QueryTurns {
public:
  using OnWait = std::function<void(const QueryWait& wait)>;

  /// @param at_once  runs at once, of each urgency
  /// @param bound    of those that wait, of each urgency
  QueryTurns(int at_once, const WaitingBound& bound);

  /// @param estimated_s  solving time [s]
  /// @param on_wait      called first, from this thread, when the work cannot begin at once
  /// @param work         does not throw
  /// @param bytes        that it keeps in memory
  /// @return             false when too much is waiting: the work was not taken
  bool post(jobs::Urgency urgency, double estimated_s, const OnWait& on_wait,
            std::function<void()> work, std::size_t bytes);

private:
  using Clock = std::chrono::steady_clock;

  struct Running {
    double estimated_s;
    Clock::time_point begin;
  };
  struct Lane {
    Lane(int threads, const WaitingBound& bound) : pool(threads, bound) {}

    std::list<double> waiting_s;  ///< estimates, in the order in which they were posted
    std::list<Running> running;
    WorkPool pool;  ///< last: its end waits for work that uses the lists
  };

  QueryWait wait_in(const Lane& lane) const;

  const int at_once_;
  std::mutex mutex_;  ///< of the lists of all lanes
  std::map<jobs::Urgency, Lane> lanes_;
};

}  // namespace dccast::service
