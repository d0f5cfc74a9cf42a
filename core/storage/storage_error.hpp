#pragma once

#include <cstdint>
#include <string>
#include <system_error>

namespace dccast::storage {

/// A file cannot be written or read: disk full, no permission, damaged. The code is the cause
/// reported by the system (ENOSPC, EACCES, ...), or EIO if it reported none.
class StorageError : public std::system_error {
public:
  /// @param where  the file, with the dataset inside it where there is one:
  /// "results.h5:/history/step"
  StorageError(int system_code, const std::string& where, const std::string& what)
      : std::system_error(system_code, std::generic_category(), where + ": " + what) {}
};

// Recognises system errors caused by a temporary lack of resources: the operation can be repeated
// later.

/// The disk is full, failing or mounted read-only, or a quota or a limit is reached.
bool is_disk_fault(const std::error_code& code);

/// A lack of memory in this process or machine: threads and mappings need it, too.
bool is_memory_fault(const std::error_code& code);

/// A disk fault, or a lack of file descriptors or memory in this process or machine.
bool is_resource_fault(const std::error_code& code);

/// A size as text, e.g. "120 MB", rounded down. @param bytes  [bytes], not negative
inline std::string megabytes(std::int64_t bytes) {
  return std::to_string(bytes / 1000000) + " MB";
}

}  // namespace dccast::storage
