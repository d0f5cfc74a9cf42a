#pragma once

#include <string>

namespace dccast::casting {

/// Behaves like a worker that a hostile file has taken over: tries to end, stop or change its
/// daemon, and to use `bytes` of memory, more than its limit.
/// @return the attempts that succeeded, one per line; empty if none did
std::string attack(std::size_t bytes);

}  // namespace dccast::casting
