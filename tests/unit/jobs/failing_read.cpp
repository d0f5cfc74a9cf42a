#include "tests/unit/jobs/failing_read.hpp"

#include <limits.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>

/// In the place of the C library's, for the whole test program.
extern "C" ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) {
  if (const char* const end = dccast::jobs::FailingRead::fails) {
    char path[PATH_MAX];
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    const ssize_t length = ::readlink(link.c_str(), path, sizeof path);
    if (length > 0 && std::string_view(path, static_cast<std::size_t>(length)).ends_with(end)) {
      errno = EIO;
      return -1;
    }
  }
  return ::syscall(SYS_pread64, file, bytes, size, offset);
}
