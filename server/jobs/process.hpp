#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/storage/file.hpp"

namespace dccast::jobs {

/// A process beyond doubt: process ids come again, the pair of id and start time does not.
struct ProcessIdentity {
  pid_t id = 0;  ///< 0: none
  std::uint64_t start_ticks =
      0;  ///< clock ticks after the machine's start, /proc/PID/stat field 22
};

/// The identity of a process that runs. @return nothing when there is none with this id
std::optional<ProcessIdentity> identify(pid_t id);

/// A pidfd of a process: readable once the process has ended, and never of another process with the
/// same id. @return nothing and `errno` when there is no such process, or a kernel without pidfds
storage::FileDescriptor open_process(pid_t process);

/// What has become of a child.
struct ChildState {
  bool running = false;
  std::optional<int> status;  ///< of waitpid(); nothing when it is not ours to wait for
};
enum class Waiting { until_its_end, not_at_all };

/// Collects a child that has ended.
ChildState collect(pid_t child, Waiting waiting);

/// How a process ended, from the status of waitpid(), in words: "exit code 3",
/// "signal 11 (Segmentation fault)".
std::string describe_exit(int wait_status);

/// The daemon's environment without what is a worker's own, and with one thread for BLAS: jobs
/// share the cores, and the solver was measured to gain nothing from two.
std::vector<std::string> worker_environment();

/// posix_spawn with signals as a program expects them: default handlers, none blocked (the daemon
/// blocks those it waits for). @return 0 or an error number
int spawn(const std::filesystem::path& program, std::vector<std::string> arguments,
          std::vector<std::string> environment, const posix_spawn_file_actions_t& actions,
          pid_t* process);

}  // namespace dccast::jobs
