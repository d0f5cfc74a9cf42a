#include "server/jobs/free_space.hpp"

#include <fcntl.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"

namespace dccast::jobs {

namespace {

using storage::megabytes;

constexpr std::size_t probe_size =
    256 * 1024;  // about what a step and a frame of a small case take

}  // namespace

void require_free_space(const std::filesystem::path& directory, std::int64_t minimum) {
  struct statvfs status;
  if (::statvfs(directory.c_str(), &status) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot look at " + directory.string());
  const auto free =
      static_cast<std::int64_t>(status.f_bavail) * static_cast<std::int64_t>(status.f_frsize);
  if (free >= minimum) return;
  throw std::system_error(ENOSPC, std::generic_category(),
                          "only " + megabytes(free) + " are free in " + directory.string() +
                              ", and minimum_free_bytes is " + megabytes(minimum));
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

}  // namespace dccast::jobs
