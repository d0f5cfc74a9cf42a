#include "core/storage/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <thread>

#include "core/storage/storage_error.hpp"

namespace dccast::storage {

namespace {

constexpr std::chrono::milliseconds between_tries{2};

/// @throws StorageError
bool try_lock(const File& file) {
  if (::flock(file.descriptor(), LOCK_EX | LOCK_NB) == 0) return true;
  if (errno == EWOULDBLOCK || errno == EINTR) return false;
  throw StorageError(errno, file.path().string(), "cannot be locked");
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path, std::chrono::milliseconds longest)
    : file_(path, O_RDWR | O_CREAT) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!(held_ = try_lock(file_)) && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(between_tries);
}

}  // namespace dccast::storage
