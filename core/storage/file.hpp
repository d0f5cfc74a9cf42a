#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace dccast::storage {

/// Owns a file descriptor of any kind (file, socket, pipe, eventfd) and closes it.
class FileDescriptor {
public:
  FileDescriptor() = default;
  /// Takes over an open descriptor; -1 for none.
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  /// Closes the descriptor. Errors of close are not seen here: sync() before.
  ~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  /// The descriptor, -1 if there is none; it stays owned.
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

private:
  int descriptor_ = -1;
};

// Permissions of new files, before the umask is applied.
inline constexpr mode_t owner_only = 0600;       ///< the daemon's own files
inline constexpr mode_t readable_by_all = 0644;  ///< the files of a run

/// Whether opening a file follows a symbolic link in its place.
enum class Links {
  refuse,  ///< for names of the program's own: a link there would redirect it to another file
  follow,  ///< a person gave the path, for example of a certificate
};

/// An open regular file. Reads and writes take an explicit offset, so that threads do not share a
/// file position. All calls throw StorageError, which names the file.
class File {
public:
  /// No file.
  File() = default;
  /// Opening never waits for another process. Anything but a regular file is refused: a named pipe,
  /// a device, a folder, and a symbolic link unless `links` permits it. With O_DIRECTORY in `flags`
  /// it is a folder that is opened, linked or not.
  /// @param flags        as for open(2); O_CLOEXEC is added, so child programs do not inherit the
  ///                     file
  /// @param permissions  for a new file
  File(const std::filesystem::path& path, int flags, mode_t permissions = owner_only,
       Links links = Links::refuse);

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

/// How often this process has synced files and directories, and how long it has waited for that.
struct SyncTotals {
  std::uint64_t count = 0;
  double seconds = 0.0;
};
/// Totals since the start of the process.
SyncTotals sync_totals();

/// As kind_of_entry() names it.
inline constexpr const char* regular_file = "a regular file";

/// What stands at a path, links not followed: "a regular file", "a folder", "a symbolic link",
/// "a named pipe", "a socket", "a device"; empty where there is nothing, or it cannot be examined.
std::string kind_of_entry(const std::filesystem::path& path);

/// Reads a whole file. @throws StorageError
std::string read_file(const std::filesystem::path& path, Links links = Links::refuse);

/// Writes a file, overwriting an existing one. The data are not synced to disk.
/// @throws StorageError
void write_file(const std::filesystem::path& path, std::string_view bytes,
                mode_t permissions = owner_only);

/// Buffered reads at any place of a file, efficient for sequential reading. Data appended after
/// construction are not seen.
class FileWindow {
public:
  /// @param file  must outlive this object
  explicit FileWindow(const File& file) : file_(file), size_(file.size()) {}

  std::int64_t size() const { return size_; }  ///< [bytes]

  /// Bytes from `offset` on, fewer at the end of the file; valid until the next call.
  /// @throws StorageError
  std::string_view at(std::int64_t offset, std::int64_t length);

private:
  /// Reads around `offset`, so that bytes_ holds the wanted range.
  void fill(std::int64_t offset, std::int64_t length);

  const File& file_;
  std::int64_t size_;
  std::int64_t begin_ = 0;  ///< offset of bytes_ in the file
  std::string bytes_;
};

// Files that survive a crash of the machine completely or not at all. All calls throw
// StorageError.

/// Syncs a directory, so that the names in it survive a crash.
void sync_directory(const std::filesystem::path& directory);

/// Creates a file whose content survives a crash; its name survives after sync_directory().
void create_durably(const std::filesystem::path& path, std::string_view content);

/// A finished file and its final name, in the same folder.
struct Publication {
  /// Name under which the content is complete and synced, and the name that readers know.
  std::filesystem::path finished;
  std::filesystem::path final_path;
};

/// Renames finished files of one folder to their final names, in this order, so that after a crash
/// either the old file or the complete new one exists.
void publish(std::initializer_list<Publication> files);

/// Replaces a file by `path`.tmp and publish(): readers see the old or the new content, never a
/// part of it. An existing entry with the temporary name is removed first; of a link, the link
/// itself.
void replace_file(const std::filesystem::path& path, std::string_view content,
                  mode_t permissions = owner_only);

}  // namespace dccast::storage
