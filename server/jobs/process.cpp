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
#include <string_view>
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

namespace {

/// As the C interface wants it: pointers into `texts`, then a null.
std::vector<char*> null_terminated(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

std::vector<std::string> worker_environment() {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (!text.starts_with("DCCAST_WORKER_") && !text.starts_with("OPENBLAS_NUM_THREADS=") &&
        !text.starts_with("OMP_NUM_THREADS=") && !text.starts_with("OMP_THREAD_LIMIT="))
      variables.emplace_back(text);
  }
  // CHOLMOD's supernodal code asks OpenMP for threads whatever OMP_NUM_THREADS is; the limit it
  // keeps to.
  variables.insert(variables.end(),
                   {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1", "OMP_THREAD_LIMIT=1"});
  return variables;
}

int spawn(const std::filesystem::path& program, std::vector<std::string> arguments,
          std::vector<std::string> environment, const posix_spawn_file_actions_t& actions,
          pid_t* process) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  // A group of its own: Ctrl-C in the terminal of a daemon is for the daemon, which ends its own.
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int error =
      ::posix_spawn(process, program.c_str(), &actions, &attributes,
                    null_terminated(arguments).data(), null_terminated(environment).data());
  posix_spawnattr_destroy(&attributes);
  return error;
}

}  // namespace dccast::jobs
