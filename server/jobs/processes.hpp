#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/storage/file.hpp"

/// Processes of the system: this one, its children, others.
namespace dccast::jobs {

/// Whether this program was built with a sanitizer.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

/// Closes the memory and the open files of this process to other processes of its user, which could
/// read and write them through /proc/PID. Root and debuggers of root still can. There are no core
/// dumps then. Not with a sanitizer, which looks for leaks from a second process.
void forbid_inspection();

/// Starts a program, looked for in PATH, with signals as it expects them: default handlers, none
/// blocked (the daemon blocks those it waits for). It leads a group of its own.
/// @param files  that become its first three  @return 0 or an error number
int spawn(std::vector<std::string> words, std::vector<std::string> environment,
          const std::array<int, 3>& files, pid_t* process);

/// The environment of this process, as "NAME=value".
/// @param having  whether to take what begins with one of the prefixes, or all the rest
std::vector<std::string> environment(bool having, std::initializer_list<std::string_view> prefixes);

/// Takes a variable out of the environment, so that no child inherits it. @return empty: not set
std::string take_variable(const char* name);

/// A pidfd of a process: readable once the process has ended, and never of another process with the
/// same id. @return nothing and `errno` when there is no such process, or a kernel without pidfds
storage::FileDescriptor open_process(pid_t process);

/// Waits for the end of a child that spawn() has started.
/// @return its status as of waitpid(); nothing: it was killed with what it has started, because it
/// took too long or the caller is asked to stop
std::optional<int> wait_for(pid_t process, std::chrono::seconds longest,
                            const std::stop_token& stop = {});

/// How a process ended, from the status of waitpid(), in words: "exit code 3",
/// "signal 11 (Segmentation fault)".
std::string describe_exit(int wait_status);

/// Memory that a process has in use [bytes]. @param process  its id; "self": this one
std::int64_t resident_bytes(const std::string& process);

/// Processor time that a process has used, with all its threads [s]; nothing: it has ended.
std::optional<double> processor_s(pid_t process);

/// Processes of one name.
struct ProcessTotals {
  int number = 0;
  std::int64_t resident_bytes = 0;
};

/// The children of this process by their names ("dccast-job"), as the system has them now: the
/// workers it has started, not those that it leads on from an earlier daemon.
std::map<std::string, ProcessTotals> child_processes();

}  // namespace dccast::jobs
