#pragma once

#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Threads for unary calls, by what a call waits for: one that takes long holds up its like, and
/// nobody else.
class Lanes {
public:
  /// @param checkers                checks at once
  /// @param query_workers           queries at once
  /// @param maximum_waiting_checks  beyond those, of each; further ones are refused
  Lanes(int checkers, int query_workers, int maximum_waiting_checks)
      : checks(checkers, bound(maximum_waiting_checks)),
        queries(query_workers, bound(maximum_waiting_checks)) {}

  static constexpr std::size_t waiting_bytes = 512'000'000;  ///< of requests, for each lane
  static constexpr WaitingBound many{.number = 10000, .bytes = waiting_bytes};

  WorkPool status{4, many};     ///< one look into the store
  WorkPool histories{2, many};  ///< reads event logs
  WorkPool durable{4, many};    ///< syncs new jobs and requests to disk
  WorkPool checks;              ///< asks a checker; one thread for each that may be at work
  WorkPool queries;             ///< from the check of a case to the end of its run; likewise

private:
  static WaitingBound bound(int waiting) {
    return {.number = static_cast<std::size_t>(waiting), .bytes = waiting_bytes};
  }
};

}  // namespace dccast::service
