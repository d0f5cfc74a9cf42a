#pragma once

#include <algorithm>
#include <array>
#include <cerrno>
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
inline bool is_disk_fault(const std::error_code& code) {
  constexpr std::array causes{ENOSPC, EDQUOT, EROFS, EIO, EFBIG};
  return std::ranges::find(causes, code.value()) != causes.end();
}

/// A lack of memory in this process or machine: threads and mappings need it, too.
inline bool is_memory_fault(const std::error_code& code) {
  return code.value() == ENOMEM || code.value() == EAGAIN;
}

/// A disk fault, or a lack of file descriptors or memory in this process or machine.
inline bool is_resource_fault(const std::error_code& code) {
  return is_disk_fault(code) || is_memory_fault(code) || code.value() == EMFILE ||
         code.value() == ENFILE;
}

/// A size as text, e.g. "120 MB", rounded down. @param bytes  [bytes], not negative
inline std::string megabytes(std::int64_t bytes) {
  return std::to_string(bytes / 1000000) + " MB";
}

}  // namespace dccast::storage
