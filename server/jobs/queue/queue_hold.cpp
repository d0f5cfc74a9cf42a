#include "server/jobs/queue/queue_hold.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <string>
#include <system_error>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "server/jobs/store/sqlite.hpp"

namespace dccast::jobs {

namespace {

// About the size of a step and a frame of a small case [bytes].
constexpr std::size_t probe_size = 256 * 1024;

// A fault that returns at once, such as a missing worker program, is retried less and less often.
constexpr QueueHold::Clock::duration shortest_interval = std::chrono::seconds(1);
constexpr QueueHold::Clock::duration longest_interval = std::chrono::seconds(30);

}  // namespace

std::optional<std::string> daemon_lacks(const std::exception& error) {
  bool lacks = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  if (const auto* system = dynamic_cast<const std::system_error*>(&error))
    lacks = storage::is_resource_fault(system->code());
  if (const auto* store = dynamic_cast<const StoreError*>(&error)) lacks = is_passing(*store);
  return lacks ? std::optional<std::string>(error.what()) : std::nullopt;
}

FreeSpaceShort::FreeSpaceShort(const std::filesystem::path& directory, std::int64_t free,
                               std::int64_t minimum)
    : std::system_error(
          ENOSPC, std::generic_category(),
          fmt::format("only {} are free in {}, and limits.minimum_free is {}",
                      storage::megabytes(free), directory.string(), storage::megabytes(minimum))),
      facts_{.reason = v1::ErrorInfo::STORAGE_FULL,
             .cause = fmt::format("only {} are free in the server's data directory",
                                  storage::megabytes(free)),
             .limit = "limits.minimum_free",
             .permitted = storage::megabytes(minimum),
             .remedy = "free space there, then try again"} {}

void require_free_space(const std::filesystem::path& directory, std::int64_t minimum) {
  struct statvfs status;
  if (::statvfs(directory.c_str(), &status) != 0)
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("cannot examine {}", directory.string()));

  const auto free =
      static_cast<std::int64_t>(status.f_bavail) * static_cast<std::int64_t>(status.f_frsize);
  if (free < minimum) throw FreeSpaceShort(directory, free, minimum);
}

void probe_directory(const std::filesystem::path& directory) {
  const std::filesystem::path path = directory / ".probe";
  {
    const storage::File file(path, O_WRONLY | O_CREAT | O_TRUNC);
    file.write_at(0, std::string(probe_size, '\0'));
    file.sync();
  }
  std::filesystem::remove(path);
}

bool QueueHold::set(const std::string& reason) {
  if (holds()) return false;
  const bool came_back = Clock::now() - lifted_ < 2 * shortest_interval;
  interval_ = came_back ? std::min(2 * interval_, longest_interval) : shortest_interval;
  reason_ = reason;
  retry_later();
  return true;
}

void QueueHold::lift() {
  reason_.reset();
  lifted_ = Clock::now();
}

void QueueHold::retry_later() {
  next_check_ = Clock::now() + interval_;
}

}  // namespace dccast::jobs
