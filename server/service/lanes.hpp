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
      : checks(checkers, static_cast<std::size_t>(maximum_waiting_checks)) {}

  static constexpr std::size_t most_waiting = 10000;  ///< beyond it memory would be the bound

  WorkPool status{4, most_waiting};     ///< one look into the store, or one order
  WorkPool histories{2, most_waiting};  ///< reads event logs
  WorkPool durable{4, most_waiting};    ///< brings new jobs to the disk
  WorkPool checks;                      ///< asks a checker; one thread for each that may be at work
};

}  // namespace dccast::service
