#include "server/jobs/process.hpp"

#include <signal.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

namespace dccast::jobs {

std::optional<ProcessIdentity> identify(pid_t id) {
  std::ifstream file("/proc/" + std::to_string(id) + "/stat");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  // The second field is the program's name in parentheses and may hold anything: count from its
  // end.
  const auto name_end = line.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(line.substr(name_end + 1));
  std::string field;
  for (int number = 3; number <= 22; ++number) rest >> field;
  if (!rest) return std::nullopt;
  return ProcessIdentity{id, std::stoull(field)};
}

storage::FileDescriptor open_process(pid_t process) {
  // glibc 2.36 declares pidfd_open() without C linkage; the system call has no such fault.
  return storage::FileDescriptor(static_cast<int>(::syscall(SYS_pidfd_open, process, 0)));
}

ChildState collect(pid_t child, Waiting waiting) {
  int status = 0;
  pid_t collected;
  do collected = ::waitpid(child, &status, waiting == Waiting::not_at_all ? WNOHANG : 0);
  while (collected < 0 && errno == EINTR);
  if (collected == child) return {.running = false, .status = status};
  return {.running = collected == 0, .status = std::nullopt};
}

std::string describe_exit(int wait_status) {
  if (WIFSIGNALED(wait_status)) {
    const int signal = WTERMSIG(wait_status);
    return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
  }
  return "exit code " + std::to_string(WEXITSTATUS(wait_status));
}

}  // namespace dccast::jobs
