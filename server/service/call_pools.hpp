#pragma once

#include <cstddef>

#include "server/service/query_turns.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Threads for calls, grouped by what a call waits for: a slow call delays only calls of its kind.
struct CallPools {
  /// @param checkers         concurrent checks
  /// @param query_workers    concurrent queries, of each urgency
  /// @param maximum_waiting  bound on waiting calls of each of these pools; further ones are
  /// refused
  CallPools(int checkers, int query_workers, int maximum_waiting)
      : few{.number = static_cast<std::size_t>(maximum_waiting), .bytes = many.bytes},
        checks(checkers, few),
        query_checks(checkers, few),
        query_turns(query_workers, few) {}

  static constexpr WaitingBound many{.number = 3000, .bytes = 64'000'000};  ///< for each pool
  const WaitingBound few;

  WorkPool status{4, many};          ///< reads the store once
  WorkPool histories{2, many};       ///< reads event logs
  WorkPool stored_answers{2, many};  ///< looks for a stored answer of a query, in event logs too
  WorkPool uploads{2, many};         ///< writes chunks of files to disk
  WorkPool durable{4, many};         ///< syncs new jobs and requests to disk
  WorkPool checks;                   ///< asks a worker; one thread for each concurrent check
  WorkPool query_checks;  ///< checks of queries, which so never wait for those of jobs and studies
  QueryTurns query_turns;
};

}  // namespace dccast::service
