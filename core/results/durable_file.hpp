#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

namespace dccast::results {

/// A file descriptor that is closed when it goes out of scope.
class FileDescriptor {
public:
  FileDescriptor() = default;
  /// @param flags  of open(2); new files get mode 0644 less the umask
  /// @throws StorageError
  FileDescriptor(const std::filesystem::path& path, int flags);
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();

  int get() const { return descriptor_; }
  const std::filesystem::path& path() const { return path_; }
  /// Writes all bytes where the descriptor stands. @throws StorageError, also on a full disk
  void write(std::string_view bytes);
  /// Waits until what was written is on the disk. @throws StorageError
  void sync();

private:
  void close();

  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// The whole content of a file. @throws StorageError
std::string read_file(const std::filesystem::path& path);

/// Writes a file, which may be in the system's cache only afterwards. @throws StorageError
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// A finished file and the name it is to have, in the same folder.
struct Publication {
  std::filesystem::path finished;
  std::filesystem::path final_path;
};

/// Gives finished files of one folder their final names, in this order, so that after a crash or a
/// loss of power there is either the old file or the whole new one: fsync of each, renames, fsync
/// of the folder. @throws StorageError
void publish(std::initializer_list<Publication> files);

/// Writes `path` by way of a temporary file beside it and publish(). @throws StorageError
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace dccast::results
