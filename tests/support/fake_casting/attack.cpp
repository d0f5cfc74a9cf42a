#include "tests/support/fake_casting/attack.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

namespace dccast::casting {

namespace {

/// Whether the kernel provides memory with these flags and lets it be used.
bool can_use_memory(std::size_t bytes, int flags) {
  void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  std::memset(memory, 1, bytes);
  ::munmap(memory, bytes);
  return true;
}

/// Whether this process can make another one, which ends at once.
bool can_fork() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  return child > 0;
}

/// Whether a write to a pipe can be made to send another process a signal that ends it. Nothing is
/// written.
bool can_direct_signal(pid_t target) {
  int ends[2];
  if (::pipe(ends) != 0) return false;
  const bool directed =
      ::fcntl(ends[0], F_SETOWN, target) == 0 || ::fcntl(ends[0], F_SETSIG, SIGKILL) == 0;
  ::close(ends[0]);
  ::close(ends[1]);
  return directed;
}

/// Whether a lock of any kind can be had on an open file.
bool can_lock(int file) {
  struct flock whole {};
  whole.l_type = F_RDLCK;
  whole.l_whence = SEEK_SET;
  for (const int kind : {F_SETLK, F_OFD_SETLK})
    if (::fcntl(file, kind, &whole) == 0) return true;
  return ::flock(file, LOCK_SH | LOCK_NB) == 0;
}

/// What can be done to a foreign file: "" for nothing.
std::string reach(const std::string& path) {
  for (const int mode : {O_RDWR, O_RDONLY}) {
    const int file = ::open(path.c_str(), mode | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) continue;
    const bool locked = can_lock(file);
    ::close(file);
    return (locked ? "locking " : mode == O_RDWR ? "opening to write " : "reading ") + path;
  }
  return {};
}

}  // namespace

std::string attack(std::size_t bytes, const std::filesystem::path& folder) {
  const pid_t daemon = ::getppid();
  std::string succeeded;
  const auto note = [&succeeded](bool success, const char* attempt) {
    if (success) succeeded += std::string(attempt) + "\n";
  };

  const rlimit nothing{0, 0};
  note(::prlimit(daemon, RLIMIT_NOFILE, &nothing, nullptr) == 0, "prlimit64 of the daemon");
  note(::setpriority(PRIO_PROCESS, static_cast<id_t>(daemon), 19) == 0,
       "setpriority of the daemon");
  note(::kill(daemon, SIGSTOP) == 0, "kill");
  note(can_direct_signal(daemon), "F_SETOWN, F_SETSIG");
  const std::string memory = "/proc/" + std::to_string(daemon) + "/mem";
  note(::open(memory.c_str(), O_WRONLY) >= 0, "writing the memory of the daemon");

  note(can_use_memory(bytes, MAP_SHARED), "a shared mapping past worker_memory");
  note(::syscall(SYS_memfd_create, "memory", 0) >= 0, "memfd_create");
  note(can_fork(), "fork");
  note(::chroot("/") == 0, "chroot");
  note(::shmget(IPC_PRIVATE, 4096, 0600) >= 0, "shmget");

  std::ifstream targets(folder / "targets");
  for (std::string path; std::getline(targets, path);)
    if (const std::string reached = reach(path); !reached.empty()) note(true, reached.c_str());
  const int own = ::open((folder / "taken").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  note(can_lock(own), "locking a file of its own");
  ::close(own);
  return succeeded;
}

}  // namespace dccast::casting
