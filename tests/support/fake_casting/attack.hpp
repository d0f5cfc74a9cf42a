#pragma once

#include <filesystem>
#include <string>

namespace dccast::casting {

/// Behaves like a worker that a hostile file has taken over: tries to end, stop or change its
/// daemon, to use `bytes` of memory, more than its limit, and to read and lock foreign files.
/// @param folder  its own; each line of the file `targets` there is the path of a foreign file
/// @return the attempts that succeeded, one per line; empty if none did
std::string attack(std::size_t bytes, const std::filesystem::path& folder);

}  // namespace dccast::casting
