#pragma once

#include <filesystem>
#include <string>

namespace dccast::client {

/// SHA-256 of a file in lower-case hexadecimal. Throws CommandFailed if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace dccast::client
