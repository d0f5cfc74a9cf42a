#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace dccast::values {

/// Two digits a byte, lower case, as every value of the contract is written.
std::string hexadecimal(std::span<const unsigned char> bytes);

/// So many bytes from the system's random numbers. @throws std::system_error
std::string random_hexadecimal(std::size_t bytes);

/// SHA-256 in lower-case hexadecimal.
std::string sha256(std::string_view bytes);

/// SHA-256 of a file, read in pieces. @param most  of its first bytes alone  @throws
/// std::system_error when it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path, std::int64_t most = INT64_MAX);

/// A random UUID (version 4) in lower case: the id of a job, of a study, of a submission that may
/// have to be repeated.
std::string random_uuid();

/// Whether `text` is a UUID in lower case, as random_uuid() writes them. Everything else is refused
/// before it comes near a path or a statement.
bool is_uuid(std::string_view text);

}  // namespace dccast::values
