#pragma once

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

}  // namespace dccast::storage
