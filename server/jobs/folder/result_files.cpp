#include "server/jobs/folder/result_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>

#include "core/storage/storage_error.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr const char* remedy = "restore it from a backup, or run the job again";

std::int64_t nanoseconds(const timespec& time) {
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  log::error("{}: {}", path.string(), why);
  throw UnsoundResult(
      fmt::format("{} on the server {}; {}", path.filename().string(), why, remedy));
}

}  // namespace

storage::File open_result(const std::filesystem::path& job_folder, const v1::Artifact& artifact) {
  const auto path = job_folder / artifact.name();
  storage::File file;
  try {
    file = storage::File(path, O_RDONLY);
  } catch (const storage::StorageError& error) {
    if (storage::is_resource_fault(error.code())) throw;
    refuse(path, fmt::format("cannot be read ({})", error.code().message()));
  }

  if (file.size() != artifact.size_bytes()) refuse(path, "has not the size that its worker wrote");
  return file;
}

ResultDigests::State ResultDigests::examine(const storage::File& file) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) != 0)
    throw storage::StorageError(errno, file.path().string(), "cannot be examined");
  return {static_cast<std::int64_t>(status.st_dev), static_cast<std::int64_t>(status.st_ino),
          status.st_size, nanoseconds(status.st_mtim), nanoseconds(status.st_ctim)};
}

void ResultDigests::require_sound(const std::filesystem::path& job_folder,
                                  const v1::Artifact& artifact) {
  constexpr std::size_t largest_count = 1000;

  const storage::File file = open_result(job_folder, artifact);
  const State state = examine(file);
  {
    const std::lock_guard lock(mutex_);
    const auto found = sound_.find(file.path());
    if (found != sound_.end() && found->second == state) return;
  }

  if (values::sha256_of_file(file.path()) != artifact.sha256())
    refuse(file.path(), "is not what its worker wrote: its SHA-256 differs");

  const std::lock_guard lock(mutex_);
  if (sound_.size() >= largest_count) sound_.clear();
  sound_[file.path()] = state;
}

}  // namespace dccast::jobs
