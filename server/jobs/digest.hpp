#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace dccast::jobs {

/// CRC-32C (Castagnoli, reflected polynomial 0x82f63b78), the checksum of an event log's records.
std::uint32_t crc32c(std::string_view bytes);

/// SHA-256 in lower-case hexadecimal.
std::string sha256(std::string_view bytes);

/// SHA-256 of a file, read in pieces. @throws std::system_error when it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace dccast::jobs
