#pragma once

#include <chrono>
#include <filesystem>

#include "core/storage/file.hpp"

namespace dccast::storage {

/// The longest a running daemon waits for a lock that another process may have.
inline constexpr std::chrono::milliseconds longest_lock_wait{1000};

/// The exclusive lock of a file (flock), which is created if it is missing. It ends with this
/// object.
class FileLock {
public:
  /// Waits for another process that has the lock, so long at most.
  /// @throws StorageError  the file cannot be opened or locked
  FileLock(const std::filesystem::path& path, std::chrono::milliseconds longest);
  /// Whether the lock was free in time.
  explicit operator bool() const { return held_; }

private:
  File file_;
  bool held_ = false;
};

}  // namespace dccast::storage
