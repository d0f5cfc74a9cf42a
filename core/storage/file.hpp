#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/storage/file_descriptor.hpp"

namespace dccast::storage {

// Permissions of new files, before the umask is applied.
inline constexpr mode_t owner_only = 0600;       ///< the daemon's own files
inline constexpr mode_t readable_by_all = 0644;  ///< the files of a run

/// An open file. Reads and writes take an explicit offset, so that threads do not share a file
/// position. All calls throw StorageError, which names the file.
class File {
public:
  File() = default;
  /// @param flags        as for open(2); O_CLOEXEC is added, so child programs do not inherit the
  ///                     file
  /// @param permissions  for a new file
  File(const std::filesystem::path& path, int flags, mode_t permissions = owner_only);

  int descriptor() const { return descriptor_.get(); }
  const std::filesystem::path& path() const { return path_; }
  std::int64_t size() const;  ///< [bytes]

  /// Reads `bytes` from `offset` on. @return number of bytes read: fewer at the end of the file
  std::size_t read_at(std::int64_t offset, std::span<char> bytes) const;
  /// Writes all of `bytes`. If it throws, a part may have been written.
  void write_at(std::int64_t offset, std::string_view bytes) const;
  /// Truncates the file to `size` bytes.
  void cut(std::int64_t size) const;
  /// Syncs the content to disk, so that it survives a crash of the machine.
  void sync() const;

private:
  FileDescriptor descriptor_;
  std::filesystem::path path_;
};

/// Reads a whole file. @throws StorageError
std::string read_file(const std::filesystem::path& path);

/// Writes a file, overwriting an existing one. The data are not synced to disk.
/// @throws StorageError
void write_file(const std::filesystem::path& path, std::string_view bytes,
                mode_t permissions = owner_only);

}  // namespace dccast::storage
