#pragma once

#include <cstdint>
#include <filesystem>

namespace dccast::jobs {

/// @throws std::system_error (ENOSPC)  the file system of a directory has less free than that
/// [bytes]
void require_free_space(const std::filesystem::path& directory, std::int64_t minimum);

/// Writes a file of some size into a directory, syncs it to disk and removes it again.
/// @throws std::system_error  the directory takes nothing
void probe_directory(const std::filesystem::path& directory);

}  // namespace dccast::jobs
