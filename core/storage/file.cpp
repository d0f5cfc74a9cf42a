#include "core/storage/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>

#include "core/storage/storage_error.hpp"

namespace dccast::storage {

namespace fs = std::filesystem;

namespace {

std::string kind_of(mode_t mode) {
  switch (mode & S_IFMT) {
    case S_IFREG:
      return regular_file;
    case S_IFDIR:
      return "a folder";
    case S_IFLNK:
      return "a symbolic link";
    case S_IFIFO:
      return "a named pipe";
    case S_IFSOCK:
      return "a socket";
    default:
      return "a device";
  }
}

[[noreturn]] void refuse_kind(int error, const std::filesystem::path& path,
                              const std::string& kind) {
  throw StorageError(error, path.string(),
                     "is " + kind + ", not " + regular_file + " (move it away)");
}

/// O_NONBLOCK has no effect on a regular file, but keeps open() of a named pipe from blocking.
int safe_flags(int flags, Links links) {
  const bool folder = (flags & O_DIRECTORY) != 0;
  if (!folder) flags |= O_NONBLOCK | O_NOCTTY;
  if (!folder && links == Links::refuse) flags |= O_NOFOLLOW;
  return flags | O_CLOEXEC;
}

constexpr std::int64_t least_read = 1 << 18;  // of a FileWindow [bytes]

std::atomic<std::uint64_t> syncs{0}, sync_ns{0};

/// Adds one sync and its own lifetime to the totals.
class TimedSync {
public:
  TimedSync() = default;
  TimedSync(const TimedSync&) = delete;
  ~TimedSync() {
    const auto taken = std::chrono::steady_clock::now() - begun_;
    syncs.fetch_add(1, std::memory_order_relaxed);
    sync_ns.fetch_add(static_cast<std::uint64_t>(
                          std::chrono::duration_cast<std::chrono::nanoseconds>(taken).count()),
                      std::memory_order_relaxed);
  }

private:
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace

File::File(const std::filesystem::path& path, int flags, mode_t permissions, Links links)
    : descriptor_(::open(path.c_str(), safe_flags(flags, links), permissions)), path_(path) {
  if (!descriptor_) {
    const int error = errno;
    // The system names the reason less clearly (ELOOP of a link, ENXIO of a pipe), or not at all.
    const std::string kind = kind_of_entry(path);
    const bool other_kind = error == ELOOP || error == ENXIO || error == EISDIR;
    if (other_kind && !kind.empty() && kind != regular_file) refuse_kind(error, path, kind);
    throw StorageError(error, path.string(), "cannot be opened");
  }

  if ((flags & O_DIRECTORY) != 0) return;
  struct stat status;
  if (::fstat(descriptor(), &status) != 0)
    throw StorageError(errno, path.string(), "cannot be examined");
  if (!S_ISREG(status.st_mode))
    refuse_kind(S_ISDIR(status.st_mode) ? EISDIR : EINVAL, path, kind_of(status.st_mode));
}

std::string kind_of_entry(const std::filesystem::path& path) {
  struct stat status;
  return ::lstat(path.c_str(), &status) == 0 ? kind_of(status.st_mode) : "";
}

std::int64_t File::size() const {
  struct stat status;
  if (::fstat(descriptor(), &status) != 0)
    throw StorageError(errno, path_.string(), "cannot be examined");
  return status.st_size;
}

std::size_t File::read_at(std::int64_t offset, std::span<char> bytes) const {
  std::size_t read = 0;
  while (read < bytes.size()) {
    const ssize_t got = ::pread(descriptor(), bytes.data() + read, bytes.size() - read,
                                offset + static_cast<std::int64_t>(read));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw StorageError(errno, path_.string(), "cannot be read");
    if (got == 0) break;
    read += static_cast<std::size_t>(got);
  }
  return read;
}

void File::write_at(std::int64_t offset, std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor(), bytes.data(), bytes.size(), offset);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) throw StorageError(errno, path_.string(), "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(put));
    offset += put;
  }
}

void File::cut(std::int64_t size) const {
  if (::ftruncate(descriptor(), size) != 0)
    throw StorageError(errno, path_.string(), "cannot be cut");
}

SyncTotals sync_totals() {
  return {syncs.load(), 1e-9 * static_cast<double>(sync_ns.load())};
}

void File::sync() const {
  const TimedSync timed;
  if (::fdatasync(descriptor()) != 0)
    throw StorageError(errno, path_.string(), "cannot be synchronised");
}

std::string read_file(const std::filesystem::path& path, Links links) {
  const File file(path, O_RDONLY, owner_only, links);
  std::string content(static_cast<std::size_t>(file.size()), '\0');
  content.resize(file.read_at(0, content));
  return content;
}

void write_file(const std::filesystem::path& path, std::string_view bytes, mode_t permissions) {
  File(path, O_WRONLY | O_CREAT | O_TRUNC, permissions).write_at(0, bytes);
}

std::string_view FileWindow::at(std::int64_t offset, std::int64_t length) {
  length = std::clamp<std::int64_t>(length, 0, std::max<std::int64_t>(size_ - offset, 0));
  if (offset < begin_ || offset + length > begin_ + static_cast<std::int64_t>(bytes_.size()))
    fill(offset, std::max(length, std::min(least_read, size_ - offset)));

  const auto available = static_cast<std::int64_t>(bytes_.size()) - (offset - begin_);
  return std::string_view(bytes_).substr(static_cast<std::size_t>(offset - begin_),
                                         static_cast<std::size_t>(std::min(length, available)));
}

void FileWindow::fill(std::int64_t offset, std::int64_t length) {
  begin_ = offset;
  bytes_.resize(static_cast<std::size_t>(length));
  bytes_.resize(file_.read_at(offset, bytes_));
}

void sync_directory(const fs::path& directory) {
  const fs::path named = directory.empty() ? fs::path(".") : directory;
  const File opened(named, O_RDONLY | O_DIRECTORY);
  const TimedSync timed;
  if (::fsync(opened.descriptor()) != 0)
    throw StorageError(errno, named.string(), "cannot be synchronised");
}

void create_durably(const fs::path& path, std::string_view content) {
  const File file(path, O_WRONLY | O_CREAT | O_EXCL);
  file.write_at(0, content);
  file.sync();
}

void publish(std::initializer_list<Publication> files) {
  for (const Publication& file : files) File(file.finished, O_RDONLY).sync();
  for (const auto& [finished, final_path] : files)
    if (std::rename(finished.c_str(), final_path.c_str()) != 0)
      throw StorageError(errno, final_path.string(), "cannot be given its final name");
  sync_directory(files.begin()->final_path.parent_path());
}

void replace_file(const fs::path& path, std::string_view content, mode_t permissions) {
  fs::path temporary = path;
  temporary += ".tmp";
  if (::unlink(temporary.c_str()) != 0 && errno != ENOENT)
    throw StorageError(errno, temporary.string(), "cannot be removed");

  write_file(temporary, content, permissions);
  publish({{temporary, path}});
}

}  // namespace dccast::storage
