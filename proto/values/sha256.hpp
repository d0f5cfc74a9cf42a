#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace dccast::values {

/// SHA-256 in lower-case hexadecimal.
std::string sha256(std::string_view bytes);

/// SHA-256 of a file, read in pieces. @throws std::system_error when it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace dccast::values
