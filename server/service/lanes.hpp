#pragma once

#include <cstddef>

#include "server/service/query_turns.hpp"
#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Threads for calls, by what a call waits for: one that takes long holds up only its like.
struct Lanes {
  /// @param checkers         checks at once
  /// @param query_workers    queries at once, of each urgency
  /// @param maximum_waiting  beyond those, of each; further ones are refused
  Lanes(int checkers, int query_workers, int maximum_waiting)
      : few{.number = static_cast<std::size_t>(maximum_waiting), .bytes = many.bytes},
        checks(checkers, few),
        query_checks(checkers, few),
        query_turns(query_workers, few) {}

  static constexpr WaitingBound many{.number = 3000, .bytes = 64'000'000};  ///< for each lane
  const WaitingBound few;

  WorkPool status{4, many};          ///< one look into the store
  WorkPool histories{2, many};       ///< reads event logs
  WorkPool stored_answers{2, many};  ///< looks whether a query was answered before; likewise
  WorkPool uploads{2, many};         ///< writes chunks of files to disk
  WorkPool durable{4, many};         ///< syncs new jobs and requests to disk
  WorkPool checks;                   ///< asks a worker; one thread for each that may be at work
  WorkPool query_checks;  ///< likewise, before a query runs: it waits for no job and no study
  QueryTurns query_turns;
};

}  // namespace dccast::service
