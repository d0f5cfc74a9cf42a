#pragma once

#include "server/service/work_pool.hpp"

namespace dccast::service {

/// Threads for unary calls, by what a call waits for: one that takes long holds up its like, and
/// nobody else.
class Lanes {
public:
  /// @param checkers                checks at once
  /// @param maximum_waiting_checks  beyond those; further ones are refused
  Lanes(int checkers, int maximum_waiting_checks)
      : checks(checkers, {.number = static_cast<std::size_t>(maximum_waiting_checks),
                          .bytes = waiting_bytes}) {}

  static constexpr std::size_t waiting_bytes = 512'000'000;  ///< of requests, for each lane
  static constexpr WaitingBound many{.number = 10000, .bytes = waiting_bytes};

  WorkPool status{4, many};     ///< one look into the store, or one order
  WorkPool histories{2, many};  ///< reads event logs
  WorkPool durable{4, many};    ///< syncs new jobs to disk
  WorkPool checks;              ///< asks a checker; one thread for each that may be at work
};

}  // namespace dccast::service
