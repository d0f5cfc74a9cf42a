#pragma once

#include <optional>
#include <vector>

#include "client/query.hpp"

namespace dccast::client {

/// Queries several cases, a few at a time: the daemon runs as many as it has cores, and the others
/// wait there. Throws CommandFailed, Interrupted; the runs end with their calls.
/// @return  (case) empty for a case with faults, which are stored in the case
std::vector<std::optional<Answer>> ask_queries(Connection& connection,
                                               std::vector<CaseUnderCheck>& cases);

}  // namespace dccast::client
