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

/// Queries of the same urgency that must finish or start before a query can run.
struct QueryWait {
  /// Queries that are being computed.
  int running = 0;
  int ahead = 0;            ///< waiting before it
  double expected_s = 0.0;  ///< until it begins, from the estimates of these queries [s]
};

/// Runs queries. Each urgency has its own threads, so that a query waits only for queries of its
/// urgency. Safe to use from several threads.
class QueryTurns {
public:
  /// Called with the present wait of a query.
  using OnWait = std::function<void(const QueryWait& wait)>;

  /// @param at_once  runs at once, of each urgency
  /// @param bound    on the waiting queries of each urgency
  QueryTurns(int at_once, const WaitingBound& bound);

  /// @param estimated_s  solving time [s]
  /// @param on_wait      called first, from this thread, when the work cannot begin at once
  /// @param work         does not throw
  /// @param bytes        memory held by the work [bytes]
  /// @return             false if too much is waiting: the work was not accepted
  bool post(jobs::Urgency urgency, double estimated_s, const OnWait& on_wait,
            std::function<void()> work, std::size_t bytes);

private:
  using Clock = std::chrono::steady_clock;

  /// A query that is being computed, with its estimated solving time [s].
  struct Running {
    double estimated_s;
    Clock::time_point begin;
  };
  /// Queries of one urgency, with the threads that run them.
  struct OneUrgency {
    OneUrgency(int threads, const WaitingBound& bound) : pool(threads, bound) {}

    std::list<double> waiting_s;  ///< estimates, in the order in which they were posted
    std::list<Running> running;
    WorkPool pool;  ///< last: its destructor runs waiting work, which uses the lists
  };

  /// What a query that is posted now would wait for.
  QueryWait wait_in(const OneUrgency& queries) const;

  const int at_once_;
  std::mutex mutex_;  ///< guards the lists of all urgencies
  std::map<jobs::Urgency, OneUrgency> of_urgency_;
};

}  // namespace dccast::service
