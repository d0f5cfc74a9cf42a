#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>

namespace dccast::jobs {

/// Whether an error means that the daemon is short of disk, descriptors or memory: a state that
/// passes, and no fault of a job. @return what is lacking, in words; nothing for any other error
std::optional<std::string> daemon_lacks(const std::exception& error);

/// @throws std::system_error (ENOSPC)  the file system of a directory has less free than that
/// [bytes]
void require_free_space(const std::filesystem::path& directory, std::int64_t minimum);

/// Writes a file of some size into a directory, syncs it to disk and removes it again.
/// @throws std::system_error  the directory takes nothing
void probe_directory(const std::filesystem::path& directory);

}  // namespace dccast::jobs
