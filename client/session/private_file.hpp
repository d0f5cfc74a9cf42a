#pragma once

#include <filesystem>
#include <string>

namespace dccast::client {

/// Writes a file that its user alone may read (mode 0600), and the folders to it. It is renamed
/// when complete: no moment in which others can read it, and a full disk leaves the old file.
/// @return why it cannot be written; empty: it is
std::string write_private_file(const std::filesystem::path& file, const std::string& text);

}  // namespace dccast::client
