#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/storage/file_descriptor.hpp"

namespace dccast::storage {

// Permissions of new files, less the umask.
inline constexpr mode_t owner_only = 0600;       ///< the daemon's own files
inline constexpr mode_t readable_by_all = 0644;  ///< the files of a run

/// An open file. Reads and writes name their place, so that threads need not share a position. All
/// calls throw StorageError, which names the file.
class File {
public:
  File() = default;
  /// @param flags        of open(2); a program that is started later does not get the descriptor
  /// @param permissions  of a new file
  File(const std::filesystem::path& path, int flags, mode_t permissions = owner_only);

  int descriptor() const { return descriptor_.get(); }
  const std::filesystem::path& path() const { return path_; }
  std::int64_t size() const;  ///< [bytes]

  /// Fills `bytes` from byte `offset` on. @return how many were read: fewer at the end of the file
  std::size_t read_at(std::int64_t offset, std::span<char> bytes) const;
  /// Writes all of `bytes`. When it throws, some of them may have been written.
  void write_at(std::int64_t offset, std::string_view bytes) const;
  /// Cuts the file off behind byte `size`.
  void cut(std::int64_t size) const;
  /// Makes the content survive a crash of the machine.
  void sync() const;

private:
  FileDescriptor descriptor_;
  std::filesystem::path path_;
};

/// The whole content of a file. @throws StorageError
std::string read_file(const std::filesystem::path& path);

/// Writes a file, over one that may be there; it may be in the system's cache only afterwards.
/// @throws StorageError
void write_file(const std::filesystem::path& path, std::string_view bytes,
                mode_t permissions = owner_only);

}  // namespace dccast::storage
