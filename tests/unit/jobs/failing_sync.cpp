#include "tests/unit/jobs/failing_sync.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

/// In the place of the C library's, for the whole test program.
extern "C" int fdatasync(int file) {
  using dccast::jobs::FailingSync;
  if (!FailingSync::fails) return static_cast<int>(::syscall(SYS_fdatasync, file));
  ++FailingSync::failures;
  errno = EROFS;
  return -1;
}
