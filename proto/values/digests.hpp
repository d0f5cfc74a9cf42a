#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace dccast::values {

/// Two lower-case digits per byte, the form of all values of the contract.
std::string hexadecimal(std::span<const unsigned char> bytes);

/// A number of bytes from the system's random number generator. @throws std::system_error
std::string random_hexadecimal(std::size_t bytes);

/// The SHA-256 of bytes that are added piece by piece.
class Sha256 {
public:
  /// OpenSSL's context is complete in the source only.
  Sha256();
  ~Sha256();
  /// Adds bytes; the order of calls counts, not how the bytes are cut.
  void add(std::string_view bytes);
  /// The digest in lower-case hexadecimal; nothing may be added afterwards.
  std::string finish();

private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// SHA-256 in lower-case hexadecimal.
std::string sha256(std::string_view bytes);

/// SHA-256 of a file, read in pieces.
/// @param most  number of bytes from its beginning; the rest is not read
/// @throws std::system_error  the file cannot be read
std::string sha256_of_file(const std::filesystem::path& path, std::int64_t most = INT64_MAX);

/// A random UUID (version 4) in lower case: the id of a job, of a study, or of a submission that
/// may be repeated.
std::string random_uuid();

/// The UUID (version 5) of a name in the namespace of dccast: the same name gives the same one.
std::string uuid_of(std::string_view name);

/// Whether `text` is a UUID in lower case, as from random_uuid(). Used to refuse everything else
/// before it becomes part of a path or of an SQL statement.
bool is_uuid(std::string_view text);

/// Whether `text` is a SHA-256 in lower-case hexadecimal.
bool is_sha256(std::string_view text);

}  // namespace dccast::values
