#include "server/jobs/processes.hpp"

#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace dccast::jobs {

void forbid_inspection() {
  if (!sanitized) ::prctl(PR_SET_DUMPABLE, 0);
}

int spawn(std::vector<std::string> words, std::vector<std::string> environment,
          const std::array<int, 3>& files, pid_t* process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (int i = 0; i < 3; ++i) posix_spawn_file_actions_adddup2(&actions, files[i], i);

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

  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> all_of_them;
    for (std::string& text : texts) all_of_them.push_back(text.data());
    all_of_them.push_back(nullptr);
    return all_of_them;
  };

  const int error = ::posix_spawnp(process, words[0].c_str(), &actions, &attributes,
                                   pointers(words).data(), pointers(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

std::vector<std::string> environment(bool having,
                                     std::initializer_list<std::string_view> prefixes) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (having == std::ranges::any_of(prefixes, [&](auto each) { return text.starts_with(each); }))
      variables.emplace_back(text);
  }
  return variables;
}

std::string take_variable(const char* name) {
  const char* value = ::getenv(name);
  std::string text = value == nullptr ? "" : value;
  ::unsetenv(name);
  return text;
}

storage::FileDescriptor open_process(pid_t process) {
  // glibc 2.36 declares pidfd_open() without C linkage; the system call has no such fault.
  return storage::FileDescriptor(static_cast<int>(::syscall(SYS_pidfd_open, process, 0)));
}

std::optional<int> wait_for(pid_t process, std::chrono::seconds longest,
                            const std::stop_token& stop) {
  constexpr int look_interval_ms = 100;  // at `stop`, and where the system has no pidfd
  const auto handle = open_process(process);
  const auto end = std::chrono::steady_clock::now() + longest;
  int status = 0;
  while (::waitpid(process, &status, WNOHANG) == 0) {
    if (stop.stop_requested() || std::chrono::steady_clock::now() > end) {
      ::kill(-process, SIGKILL);
      ::waitpid(process, &status, 0);
      return std::nullopt;
    }
    pollfd ended{handle.get(), POLLIN, 0};
    ::poll(&ended, 1, look_interval_ms);
  }
  return status;
}

std::string describe_exit(int wait_status) {
  if (WIFSIGNALED(wait_status)) {
    const int signal = WTERMSIG(wait_status);
    return "signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
  }
  return "exit code " + std::to_string(WEXITSTATUS(wait_status));
}

std::int64_t resident_bytes(const std::string& process) {
  std::ifstream file("/proc/" + process + "/statm");
  std::int64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * ::sysconf(_SC_PAGESIZE);
}

std::optional<double> processor_s(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &used) != 0)
    return std::nullopt;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::map<std::string, ProcessTotals> child_processes() {
  std::map<std::string, ProcessTotals> totals;
  std::error_code error;
  for (std::filesystem::directory_iterator task("/proc/self/task", error), end;
       !error && task != end; task.increment(error)) {
    std::ifstream children(task->path() / "children");
    for (std::string process; children >> process;) {
      std::string name;
      std::getline(std::ifstream("/proc/" + process + "/comm"), name);
      if (name.empty()) continue;  // it has ended
      ProcessTotals& total = totals[name];
      ++total.number;
      total.resident_bytes += resident_bytes(process);
    }
  }
  return totals;
}

}  // namespace dccast::jobs
