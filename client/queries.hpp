#pragma once

#include <optional>
#include <vector>

#include "client/query.hpp"

namespace dccast::client {

/// Asks about several cases at once, a few at a time: the daemon has processes for as many as it
/// has cores, and the others wait there.
/// @return  in the order of the cases; nothing for a case with faults, which are in it then
/// Throws CommandFailed, Interrupted: the runs end with their calls.
std::vector<std::optional<Answer>> ask_queries(Connection& connection,
                                               std::vector<CaseUnderCheck>& cases);

}  // namespace dccast::client
